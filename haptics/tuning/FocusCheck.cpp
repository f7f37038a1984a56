#include "haptics/tuning/FocusCheck.h"

#include "haptics/array/Medium.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

constexpr double kSearch_m = 5e-3; // largest displacement of the microphone
constexpr double kCoarse_m = 1e-3;
constexpr double kFine_m = 0.05e-3;
constexpr int kLeastRows = 20;

/// Foci of one place: drives and measurements.
class Foci
{
public:
    Foci(const TransducerArray& tuned,
         const TuningPlan& plan,
         const TuningReadings& readings,
         int place) :
        _tuned(tuned),
        _plan(plan),
        _place(place)
    {
        _medium.temperature_C =
            base::kZeroCelsius_K * (std::pow(plan.soundSpeed_m_s / 331.3, 2.0) - 1.0);
        double silence = 0.0;
        int silent = 0;
        for (int k = 0; k < plan.size(); ++k)
        {
            const TuningRow& row = plan.rows[static_cast<std::size_t>(k)];
            const double level = std::abs(readings.values[k]);
            if (row.place != place || !std::isfinite(level)) continue;
            if (row.dutyLevel == 0)
            {
                silence += level * level;
                ++silent;
            }
            else
                (row.element < 0 ? _foci : _singles).push_back({k, level});
        }
        _silence = silent > 0 ? silence / silent : 0.0;
        for (auto* rows : {&_foci, &_singles})
            for (Measured& row : *rows)
                row.level = std::sqrt(std::max(0.0, row.level * row.level - _silence));
    }

    bool areEnough() const { return _foci.size() >= kLeastRows && _singles.size() >= 8; }

    double loudest() const
    {
        double most = 0.0;
        for (const Measured& row : _foci)
            most = std::max(most, row.level);
        return most;
    }
    double silence() const { return std::sqrt(_silence); }

    FocusFigures figures()
    {
        prepare();
        FocusFigures figures;
        figures.place = _plan.places.col(_place);
        search(figures.place, kSearch_m, kCoarse_m);
        search(figures.place, kCoarse_m, 0.25 * kCoarse_m);
        search(figures.place, 0.25 * kCoarse_m, kFine_m);
        const Eigen::VectorXd predicted = predictedAt(figures.place);
        figures.ratio = scaleOf(predicted) / singleScale(figures.place);
        for (int axis = 0; axis < 3; ++axis)
        {
            figures.width_m[axis] = widthAlong(axis, _measured);
            figures.predictedWidth_m[axis] = widthAlong(axis, predicted);
        }
        return figures;
    }

private:
    struct Measured
    {
        int row;
        double level; ///< without silence
    };

    // Computes each focus's drive, m x foci.
    void prepare()
    {
        _q.resize(_plan.transducers, static_cast<Eigen::Index>(_foci.size()));
        _measured.resize(_q.cols());
        for (Eigen::Index f = 0; f < _q.cols(); ++f)
        {
            const Measured& focus = _foci[static_cast<std::size_t>(f)];
            const TuningDrive drive =
                driveOf(_plan, _plan.rows[static_cast<std::size_t>(focus.row)], &_tuned);
            for (Eigen::Index i = 0; i < _q.rows(); ++i)
                _q(i, f) =
                    std::polar(base::dutyAmplitude(drive.duty[static_cast<std::size_t>(i)]),
                               base::kTwoPi * drive.phase[static_cast<std::size_t>(i)] / 256);
            _measured[f] = focus.level;
        }
    }

    Eigen::VectorXd predictedAt(const Eigen::Vector3d& place) const
    {
        return (referencePropagationMatrix(place, _tuned, _medium) * _q).cwiseAbs().transpose();
    }

    double scaleOf(const Eigen::VectorXd& predicted) const
    {
        return predicted.dot(_measured) / predicted.squaredNorm();
    }

    // Moves \a place to the best match of predicted and measured levels.
    void search(Eigen::Vector3d& place, double reach_m, double step_m) const
    {
        const int steps = static_cast<int>(std::lround(reach_m / step_m));
        const Eigen::Vector3d middle = place;
        double best = -1.0;
        for (int x = -steps; x <= steps; ++x)
            for (int y = -steps; y <= steps; ++y)
                for (int z = -steps; z <= steps; ++z)
                {
                    const Eigen::Vector3d at = middle + step_m * Eigen::Vector3d(x, y, z);
                    if ((at - middle).norm() > 1.01 * reach_m) continue;
                    const Eigen::VectorXd predicted = predictedAt(at);
                    const double likeness = predicted.dot(_measured) / predicted.norm();
                    if (likeness <= best) continue;
                    best = likeness;
                    place = at;
                }
    }

    // Readings' unit per Pa, from transducers that play alone.
    double singleScale(const Eigen::Vector3d& place) const
    {
        const Eigen::MatrixXcd G = referencePropagationMatrix(place, _tuned, _medium);
        std::vector<double> scales;
        for (const Measured& single : _singles)
        {
            const TuningRow& row = _plan.rows[static_cast<std::size_t>(single.row)];
            const double alone = std::abs(G(0, row.element)) * base::dutyAmplitude(row.dutyLevel);
            if (alone > 0.0) scales.push_back(single.level / alone);
        }
        return base::percentile(scales, 0.5);
    }

    // Full width at half maximum of the levels of foci along an axis.
    double widthAlong(int axis, const Eigen::VectorXd& levels) const
    {
        std::vector<std::pair<double, double>> line;
        const Eigen::Vector3d planned = _plan.places.col(_place);
        for (std::size_t f = 0; f < _foci.size(); ++f)
        {
            const Eigen::Vector3d d =
                _plan.rows[static_cast<std::size_t>(_foci[f].row)].focus - planned;
            if ((d - d[axis] * Eigen::Vector3d::Unit(axis)).norm() < 1e-6)
                line.emplace_back(d[axis], levels[static_cast<Eigen::Index>(f)]);
        }
        std::sort(line.begin(), line.end());
        if (line.empty()) return 0.0;
        const auto top =
            std::max_element(line.begin(),
                             line.end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; });
        const double half = 0.5 * top->second;
        double low = -std::numeric_limits<double>::infinity(), high = -low;
        const auto crossing = [half](const auto& in, const auto& out) {
            return in.first +
                   (out.first - in.first) * (in.second - half) / (in.second - out.second);
        };
        for (auto at = top; at != line.begin(); --at)
            if (std::prev(at)->second < half)
            {
                low = crossing(*at, *std::prev(at));
                break;
            }
        for (auto at = top; std::next(at) != line.end(); ++at)
            if (std::next(at)->second < half)
            {
                high = crossing(*at, *std::next(at));
                break;
            }
        return high - low;
    }

    const TransducerArray& _tuned;
    const TuningPlan& _plan;
    const int _place;
    Medium _medium;
    std::vector<Measured> _foci, _singles;
    double _silence = 0.0; ///< mean square
    Eigen::MatrixXcd _q;
    Eigen::VectorXd _measured;
};

std::string widthText(double width_m)
{
    return std::isfinite(width_m) ? fmt::format("{:.1f}", 1e3 * width_m) : std::string("over 24");
}

} // namespace

bool FocusCheck::passes(double least) const
{
    return refusal.empty() && !places.empty() &&
           std::all_of(places.begin(),
                       places.end(),
                       [least](const FocusFigures& at) { return at.ratio >= least; });
}

std::string FocusCheck::text() const
{
    std::string text;
    auto out = std::back_inserter(text);
    for (const std::string& note : notes)
        fmt::format_to(out, "note        {}\n", note);
    if (!refusal.empty()) fmt::format_to(out, "refused     {}\n", refusal);
    for (std::size_t p = 0; p < places.size(); ++p)
    {
        const FocusFigures& at = places[p];
        fmt::format_to(
            out,
            "place {:<6}focus {:.3f} of the predicted level; width at half pressure in x, "
            "y, z\n            {}, {}, {} mm, predicted {}, {}, {} mm; microphone at "
            "({:.4f}, {:.4f}, {:.4f}) m\n",
            p,
            at.ratio,
            widthText(at.width_m.x()),
            widthText(at.width_m.y()),
            widthText(at.width_m.z()),
            widthText(at.predictedWidth_m.x()),
            widthText(at.predictedWidth_m.y()),
            widthText(at.predictedWidth_m.z()),
            at.place.x(),
            at.place.y(),
            at.place.z());
    }
    return text;
}

FocusCheck
checkFocus(const TransducerArray& tuned, const TuningPlan& plan, const TuningReadings& readings)
{
    if (plan.method != TuningMethod::FOCUS)
        throw base::InputError(fmt::format("the plan is of the method {}; a check needs one of the "
                                           "method focus",
                                           tuningMethodName(plan.method)));
    plan.requireFor(tuned);
    FocusCheck check;
    check.notes = readings.notes();
    for (int place = 0; place < static_cast<int>(plan.places.cols()); ++place)
    {
        Foci foci(tuned, plan, readings, place);
        if (!foci.areEnough())
            check.refusal = fmt::format("there are too few readings of place {}", place);
        else if (!(foci.loudest() > 5.0 * foci.silence()))
            check.refusal = fmt::format(
                "the microphone hears no focus at place {}: at most {:.3g}, in silence {:.3g}",
                place,
                foci.loudest(),
                foci.silence());
        if (!check.refusal.empty()) break;
        check.places.push_back(foci.figures());
    }
    return check;
}

} // namespace midair::haptics
