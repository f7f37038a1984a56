#include "haptics/sequence/CycleEqualizer.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Range.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/SurfaceStatistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace midair::haptics
{

namespace
{

// Explained in haptics/SOLVER.md, "Fields in turn".
constexpr int kInnerSteps = 8;     // conjugate gradient steps for each correction of a field
constexpr double kMargin = 1.03;   // target over the mean pressure that must be kept
constexpr double kMostRaise = 1.1; // largest factor on the target after a sweep

// Returns the mean radiation pressure of the first field that is not silent, Pa; 0 if all are.
double firstAlone_Pa(const Eigen::Matrix3Xd& surface,
                     const TransducerArray& array,
                     const Medium& medium,
                     const std::vector<Eigen::VectorXcf>& fields,
                     int threads,
                     const base::StopToken& stop)
{
    const auto first = std::find_if(
        fields.begin(), fields.end(), [](const Eigen::VectorXcf& q) { return !q.isZero(0.0f); });
    if (first == fields.end()) return 0.0;
    return meanRadiationPressure(surface, array, medium, {*first}, 2.0, threads, stop).mean();
}

} // namespace

bool CycleEqualizerOptions::isValid(std::string* error) const
{
    return base::RangeCheck()
        .atLeast("sweeps", sweeps, 0)
        .atLeast("corrections", corrections, 1)
        .above("loudness", loudness, 0.0)
        .passed(error);
}

CycleEqualizer::CycleEqualizer(const CycleEqualizerOptions& options, const SolverOptions& solver) :
    _options(options),
    _threads(solver.threads),
    _stop(solver.stop),
    _dense(solver.pool ? solver.pool
                       : std::make_shared<base::ThreadPool>(std::max(solver.threads, 1)),
           Storage::FLOAT,
           solver.stop)
{
    std::string error;
    if (!options.isValid(&error)) throw base::InputError("evening a cycle out: " + error);
}

void CycleEqualizer::even(const Eigen::Matrix3Xd& surface,
                          const TransducerArray& array,
                          const Medium& medium,
                          std::vector<Eigen::VectorXcf>& fields)
{
    if (surface.cols() == 0 || _options.sweeps == 0) return;
    const double alone_Pa = firstAlone_Pa(surface, array, medium, fields, _threads, _stop);
    if (!(alone_Pa > 0.0)) return;
    ControlPoints points;
    points.positions = surface;
    points.targets = Eigen::VectorXd::Ones(surface.cols());
    std::vector<int> all(static_cast<std::size_t>(surface.cols()));
    std::iota(all.begin(), all.end(), 0);
    _dense.assign(points, all, array, medium, 0.0);
    _dense.build();

    const auto K = static_cast<float>(fields.size());
    double goal = kMargin * _options.loudness * alone_Pa / radiationPressure(1.0, medium);
    const double floor = goal / kMargin;
    LevenbergMarquardt::Limits limits;
    limits.corrections = _options.corrections;
    limits.innerSteps = kInnerSteps;
    std::vector<Eigen::VectorXf> squares(fields.size(), Eigen::VectorXf::Zero(surface.cols()));
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(surface.cols());
    // Fields that are not silent; a set without points stays silent.
    std::vector<std::size_t> sounding;
    for (std::size_t k = 0; k < fields.size(); ++k)
        if (!fields[k].isZero(0.0f)) sounding.push_back(k);
    for (const std::size_t k : sounding)
    {
        setPhases(_dense, fields[k]);
        _dense.forward(_dense.q, _dense.p);
        _dense.phasesOf(_dense.p);
        squares[k] = _dense.y.cwiseAbs2();
        sum += squares[k];
    }
    for (int sweep = 0; sweep < _options.sweeps; ++sweep)
    {
        for (const std::size_t k : sounding)
        {
            setPhases(_dense, fields[k]);
            const Eigen::VectorXf given = Eigen::VectorXf::Constant(sum.size(), K - 1.0f) -
                                          (sum - squares[k]) / static_cast<float>(goal);
            _descent.fit(_dense, std::sqrt(goal), given, limits);
            sum -= squares[k];
            squares[k] = _dense.y.cwiseAbs2();
            sum += squares[k];
            fields[k] = sweep + 1 < _options.sweeps ? currentPhases(_dense) : playedPhases(_dense);
        }
        const double mean = static_cast<double>(sum.mean() / K);
        if (mean < floor) goal *= std::clamp(floor / std::max(mean, 1e-30), 1.0, kMostRaise);
    }
}

} // namespace midair::haptics
