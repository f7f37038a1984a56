#pragma once

#include "samples/paper/PaperArray.h"

namespace midair::samples
{

/// Returns five tips, five notches and the centre of a pentagram in the cross-section xz, 3 x 11;
/// \a width_m: from tip to tip across, metres, > 0.
Eigen::Matrix3Xd flatStar(double width_m);

/// Solves flat stars with GS, SDP relaxation and the default solver from an equal start and
/// \a starts random ones, >= 1, and prints how the weakest over the strongest pressure is
/// distributed.
void printStarStarts(const PaperArray& paper, int starts);

} // namespace midair::samples
