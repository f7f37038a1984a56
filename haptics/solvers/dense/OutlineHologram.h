#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/solvers/dense/LevenbergMarquardt.h"
#include "haptics/surface/Outline.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::haptics
{

/// How outlines are solved for; isValid() names the first setting that is out of its range.
struct OutlineOptions
{
    double spacing = 0.245; ///< 0.1 .. 1, in wavelengths; between the points that are solved for
    int starts = 8;         ///< 1 .. 1000; starting phases that are tried
    int finalists = 3;      ///< >= 1; of those, how many are followed to the end
    int rounds = 30;        ///< >= 1; weighted projections from each start
    int corrections = 60;   ///< >= 0; of LevenbergMarquardt, for each finalist
    /// > 0; the mean radiation pressure to be kept, over that of the loudest start with points a
    /// wavelength apart.
    double loudness = 1.0;
    /// True: where outlines of as many points were solved before, the field of then is the one
    /// start.
    bool warmStart = true;
    std::uint64_t seed = 1;                 ///< of the random starts
    int threads = 1;                        ///< >= 1
    std::shared_ptr<base::ThreadPool> pool; ///< as SolverOptions::pool
    base::StopToken stop;                   ///< where it asks for that, solve() throws Stopped

    /// False where a setting is out of its range; \a error, if given, then says which.
    bool isValid(std::string* error = nullptr) const;
};

/// What was reached, for the activations as the device plays them.
struct OutlineReport
{
    /// One start and what it led to; the finalists' figures are of their end, the others' of their
    /// first corrections.
    struct Start
    {
        std::string name;
        double mean_Pa = 0.0;
        double coefficientOfVariation = 0.0;
        bool finalist = false;
    };

    int points = 0;
    std::vector<Start> starts;
    int chosen = -1; ///< index into starts
    /// Radiation pressure along the outlines, a tenth of a wavelength apart, over the square of
    /// their targets.
    SurfaceStatistics along;
    SurfaceStatistics apart; ///< the same of the loudest field for points a wavelength apart
    bool loudEnough = false; ///< along.mean_Pa is at least loudness times apart.mean_Pa
    int corrections = 0;     ///< of the chosen start
    double solve_ms = 0.0;
};

/// Plays outlines in one stationary field, nearly without ripples. The points stand a quarter of a
/// wavelength apart and all are solved for: weighted projections, then LevenbergMarquardt. Where
/// that leads depends on the phases it starts from, so equal ones, ramps along the curve and random
/// ones are tried; the smoothest field wins that is no less loud than one for points a wavelength
/// apart. Phase-only: all transducers play at full amplitude.
class OutlineHologram
{
public:
    /// Throws InputError for options that are not valid.
    explicit OutlineHologram(const OutlineOptions& options = {});

    /// m activations into \a q, on the array's levels. Throws InputError where outlines, array or
    /// medium are not valid or the outlines too long (Limits.h), Stopped where that is asked for.
    OutlineReport solve(const std::vector<Outline>& outlines,
                        const TransducerArray& array,
                        const Medium& medium,
                        Eigen::VectorXcf& q);

    const OutlineOptions& options() const { return _options; }
    /// The points that the last field was solved for, their targets those of their outlines.
    const ControlPoints& points() const { return _points; }
    /// mean_l sum_i |G_li| at these points, Pa: what all transducers in phase would give there.
    double meanRowSum_Pa() const { return _field.meanRowSum(); }

private:
    struct Candidate
    {
        int start = 0;
        double goal_Pa = 0.0;
        int corrections = 0;
        SurfaceStatistics along;
        Eigen::VectorXcf q; // unit phases before they are rounded
    };

    struct Scene
    {
        const std::vector<Outline>& outlines;
        const TransducerArray& array;
        const Medium& medium;
        Eigen::Matrix3Xd dense;  // where the pressure is judged
        Eigen::VectorXd targets; // of the outlines there
        double unit_Pa;          // radiation pressure of 1 Pa
    };

    void checkLength(const std::vector<Outline>& outlines, double wavelength_m) const;
    void place(const Scene& scene, double spacing_m);
    std::string start(int index);
    SurfaceStatistics judge(const Scene& scene, Eigen::VectorXcf* played = nullptr);
    SurfaceStatistics solveApart(const Scene& scene, double spacing_m);
    void follow(const Scene& scene, int corrections, Candidate& candidate);
    void raise(const Scene& scene, double floor_Pa, Candidate& candidate);
    std::vector<Candidate> begin(const Scene& scene, double floor_Pa, OutlineReport& report);
    void finish(const Scene& scene,
                double floor_Pa,
                std::vector<Candidate>& candidates,
                OutlineReport& report,
                Eigen::VectorXcf& q);

    OutlineOptions _options;
    FieldProblem _field;
    LevenbergMarquardt _even;
    ControlPoints _points;      // at hand
    std::vector<double> _along; // of the points at hand: share of their outline's length
    Eigen::VectorXcf _last;     // unit phases before they were rounded; empty: none
    int _lastPoints = 0;
    SurfaceStatistics _lastApart;
};

} // namespace midair::haptics
