#pragma once

#include "samples/tools/solve/Solution.h"

#include <string>

namespace midair::samples
{

/// The name of the kit's own hand as a scatterer.
constexpr const char* kScatteringHand = "hand";

/// Sets the true field of \a solution, whose scene is loaded, with the thing of --scatterer: the
/// rigid body of an OBJ file (metres, array frame), the kit's hand above the points of \a task, or
/// the rigid rectangles among the reflectors, as screens. Does nothing without one. Says on stderr
/// what it takes before it begins, and how far it is. Throws base::InputError, which names the
/// file.
void loadScatterer(const SolveArguments& arguments,
                   const bridge::SolveTask& task,
                   Solution& solution);

/// Corrects the fields of \a solution, made for \a task, for its truth, keeps them if they err
/// less, and sets its figures of the scatterer. Throws base::InputError for points inside.
void correctForScatterer(const SolveArguments& arguments,
                         const bridge::SolveTask& task,
                         Solution& solution);

/// Writes field,x_m,y_m,z_m,with_re_Pa,with_im_Pa,free_re_Pa,free_im_Pa, the pressures with the
/// thing and without it, to \a path. Throws base::InputError.
void writeScattering(const std::string& path, const Solution& solution);

/// Prints the line "scatterer".
void printScattering(const SolvedScatterer& some);

} // namespace midair::samples
