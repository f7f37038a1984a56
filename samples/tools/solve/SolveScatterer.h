#pragma once

#include "samples/tools/solve/Solution.h"

#include <string>

namespace midair::samples
{

/// Returns what the rigid body of the OBJ file \a file (metres, array frame) does to the fields of
/// \a solution. Says on stderr what it takes before it begins. Throws base::InputError, which names
/// the file.
haptics::ScatteringFigures
scatteredBy(const std::string& file, const Solution& solution, int threads);

/// Writes field,x_m,y_m,z_m,with_re_Pa,with_im_Pa, the pressures with the body, to \a path. Throws
/// base::InputError.
void writeScattering(const std::string& path,
                     const haptics::ScatteringFigures& figures,
                     const Solution& solution);

/// Prints the line "scatterer".
void printScattering(const haptics::ScatteringFigures& figures);

} // namespace midair::samples
