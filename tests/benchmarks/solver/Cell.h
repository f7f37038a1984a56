#pragma once

#include "haptics/array/Reflector.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/solvers/HologramSolver.h"

#include <string>
#include <vector>

namespace midair::bench
{

/// One cell of the benchmark: a point set, a solver, and how it is run.
struct Cell
{
    std::string kase = "sphere"; ///< sphere, star, line, or the path of an OBJ file
    int points = 100;            ///< of sphere, star and line; a mesh is sampled a wavelength apart
    double radius_m = 0.03;      ///< half the largest extent
    std::string solver;
    std::string mode =
        "update"; ///< update: the object has moved by 1 mm and 1 degree; cold: from nothing
    int threads = 1;
    int iterations = 0; ///< limit; 0: the method's own
    int repeats = 41;
    bool unequal = false;                       ///< targets from 0.3 to 1 instead of equal ones
    double loudness = 1.0;                      ///< over 1: more of it, at the price of error
    std::vector<haptics::Reflector> reflectors; ///< beside the array
    bool surface = true; ///< the last field is measured over the surface and against the bound
};

/// What a cell comes to: medians over its repeats; times of the whole call, matrix included.
struct Result
{
    Cell cell;
    int points = 0;
    int transducers = 0;
    double time_ms = 0.0, cpu_ms = 0.0, matrix_ms = 0.0;
    double rms = 0.0, max = 0.0, loudness = 0.0;
    double worstRms = 0.0, leastLoudness = 0.0; ///< over the repeats
    double roofline_ms =
        0.0; ///< one build of the matrix and one read of it, on one thread, in this run
    double phaseStep_rad = 0.0, audibleChange = 0.0;
    haptics::SolveReport last; ///< of the last field
    /// u* M u (lambdaRel 0.1) of the last field's phases, the certified bound below all, and the
    /// gap between them; 0: not had.
    double objective = 0.0, bound = 0.0, gap = 0.0;
    int iterations = 0;
};

/// Throws InputError for a case, mode or solver that is not known.
Result run(const Cell& cell);

void writeCsv(const std::string& path, const std::vector<Result>& results);
void writeJson(const std::string& path, const std::vector<Result>& results);

} // namespace midair::bench
