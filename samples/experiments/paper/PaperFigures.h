#pragma once

#include "samples/experiments/paper/PaperArray.h"

#include <string>

namespace midair::samples
{

/// Returns five tips, five notches and the centre of a pentagram in the cross-section xz, 3 x 11;
/// \a width_m: from tip to tip across, metres, > 0.
Eigen::Matrix3Xd flatStar(double width_m);

/// Solves flat stars with GS, SDP relaxation and the default solver from an equal start and
/// \a starts random ones, >= 1, and prints how the weakest over the strongest pressure is
/// distributed.
void printStarStarts(const PaperArray& paper, int starts);

/// Draws the paper's figures 3, 4, 6 and 7 anew into \a folder, as paper_figure3.png and so on, and
/// prints the numbers in them beside the paper's: the flat star of 34 mm by GS and by SDP
/// relaxation, the focus and the line. The stars are those of the random start, of \a starts >= 1,
/// whose evenness is the median one. Throws base::InputError if one can't be written.
void drawPaperFigures(const PaperArray& paper, int starts, const std::string& folder);

} // namespace midair::samples
