#pragma once

#include "tests/referee/Recorded.h"

#include <complex>
#include <map>
#include <string>
#include <vector>

namespace midair::referee
{

/// A figure's true value. A count is true within a range: a point that is short by 1 % to within
/// single precision counts or does not. So is the largest error, of points with low targets.
struct Truth
{
    double least = 0.0, most = 0.0; ///< equal but for these
    bool isCount = false;           ///< any difference is false
};

/// The figures of one update, by the names of kFigures.
struct Recomputed
{
    std::map<std::string, Truth> figures;
    /// What keeping rows of G adds, which reports leave out: the same errors at the places that
    /// were asked for.
    double rmsAsked = 0.0, maxAsked = 0.0;
    double worstMove_m = 0.0; ///< largest distance of such a place from that of its row
    double loudest_Pa = 0.0;  ///< the largest |p| at a point
};

/// Recomputes the figures of a recording from the levels that were played, in double, with
/// ReferencePropagation for the field and with nothing of the solver: definitions are those in
/// FieldFigures, written down again. One recording, update by update in order.
class Recomputer
{
public:
    explicit Recomputer(const Recorded& recorded);

    Recomputed next();

private:
    /// What one solver keeps from update to update, as the skip tolerance lets it.
    struct Rows
    {
        std::vector<int> active;    ///< points with a target that the array reaches
        Eigen::Matrix3Xd places;    ///< of these, where their rows of G were built
        Eigen::MatrixXcd kept;      ///< G at these places
        Eigen::MatrixXcd asked;     ///< G where this update asks for them
        Eigen::Matrix3Xd solvedFor; ///< all points of the last solve
        int built = 0;              ///< rows that it built
        double worstMove_m = 0.0;
    };
    /// Sums over the fields of an update.
    struct Sums
    {
        double squares = 0.0, squaresAsked = 0.0, maxAsked = 0.0;
        double surelyMax = 0.0, perhapsMax = 0.0;
        double squaresOfLargest = 0.0, maxOfLargest = 0.0;
        double level_Pa = 0.0, loudness = 0.0, worstShortfall = 0.0;
        int points = 0, rated = 0, built = 0, surelyShort = 0, perhapsShort = 0;
    };

    Rows& choosePlaces(const Part& part, const Update& update);
    void ratePart(const Part& part, const Rows& rows, Sums& sums, Recomputed& result) const;
    void setAll(const Sums& sums, Recomputed& result);
    void rateChange(Recomputed& result) const;
    void rateCap(Recomputed& result) const;
    void rateRinging(Recomputed& result) const;
    void rateSurface(const Update& update, Recomputed& result);
    Eigen::VectorXcd playedIn(const Part& part) const;

    const Recorded& _recorded;
    double _audibleShare;
    std::size_t _next = 0;
    std::map<int, Rows> _rows;
    std::vector<Eigen::VectorXcd> _q; ///< of this update
    Eigen::VectorXcd _lastQ;          ///< the first field of the one before; empty: none
    double _level_Pa = 0.0;           ///< of this update
    double _lastLevel_Pa = 0.0;
    std::size_t _measured = 0; ///< update of which the newest surface figures are
    std::map<std::string, Truth> _surface;
    haptics::SurfaceStatistics _toldSurface;
};

/// The part of a held change's energy between 20 Hz and 20 kHz from the carrier, at \a rate_Hz:
/// the integral of sinc^2 in closed form, by the sine integral.
double audiblePart(double rate_Hz);

} // namespace midair::referee
