#include "engine-bridge/pipeline/HologramResult.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>

namespace midair::bridge
{

const Eigen::VectorXcf& HologramResult::played() const
{
    static const Eigen::VectorXcf kNone;
    return sequence.fields.empty() ? kNone : sequence.fields.front();
}

double UpdateRate::perSecond(double now_s)
{
    while (!_times_s.empty() && _times_s.front() < now_s - 1.0)
        _times_s.pop_front();
    return static_cast<double>(_times_s.size());
}

void count(const PointAssembler& assembler,
           const AssembledPoints& assembled,
           HologramCounters& counters)
{
    counters.meshesSampled = assembler.sampled();
    counters.meshesFollowed = assembler.followed();
    counters.outOfWorkspace += assembled.outOfWorkspace;
    counters.overBudget += assembled.overBudget;
    counters.crowded += assembled.crowded;
    counters.unpainted += assembled.unpainted;
}

void count(const haptics::SolveReport& report, HologramCounters& counters)
{
    ++counters.solves;
    counters.rowsBuilt += static_cast<std::uint64_t>(report.rowsBuilt);
    counters.rowsKept += static_cast<std::uint64_t>(std::max(0, report.points - report.rowsBuilt));
}

namespace
{

/// Returns true if \a planned is quieter than \a solved by more than rounding can explain.
bool isLowered(const std::vector<Eigen::VectorXcf>& planned,
               const std::vector<Eigen::VectorXcf>& solved)
{
    constexpr float kLeast = 0.99F;
    bool lowered = false;
    for (std::size_t k = 0; k < planned.size() && k < solved.size(); ++k)
        lowered = lowered || planned[k].norm() < kLeast * solved[k].norm();
    return lowered;
}

/// Returns true if they differ by at most the device's tables of levels.
bool isSame(const Eigen::VectorXcf& a, const Eigen::VectorXcf& b)
{
    constexpr float kRounding = 1e-6F;
    return a.size() == b.size() && (a - b).squaredNorm() <= kRounding * kRounding * b.squaredNorm();
}

} // namespace

void ratePlayed(HologramResult& result)
{
    // Below it a focus presses with less than 0.2 mN, which is not perceptible: contacts begin and
    // end so faintly that an error relative to their target is meaningless there.
    constexpr double kUnfelt_Pa = 1000.0;
    haptics::SolveReport& report = result.sequence.report;
    if (result.foci == 0) return haptics::rateLevel(result.points, result.achieved_Pa, report);
    const int wholes = result.points.size() - result.foci;
    double least_Pa = kUnfelt_Pa; // the pressures of whole objects are wanted, too
    if (wholes > 0)
        least_Pa = std::max<double>(least_Pa, result.achieved_Pa.head(wholes).maxCoeff());
    std::vector<int> which(static_cast<std::size_t>(result.foci));
    std::iota(which.begin(), which.end(), wholes);
    haptics::ControlPoints own = haptics::pick(result.points, which);
    own.absolute = true;
    haptics::rateLevel(own, result.achieved_Pa.tail(result.foci), report, least_Pa);
}

bool measurePlayed(const ArrayOutput& output,
                   const haptics::TransducerArray& array,
                   const haptics::Medium& medium,
                   const haptics::SolverOptions& options,
                   const CappedField& known,
                   HologramResult& result,
                   bool isRated)
{
    haptics::FieldSequence& sequence = result.sequence;
    const auto achieved_Pa = [&](std::vector<Eigen::VectorXcf> fields)
    {
        sequence.fields = std::move(fields);
        const bool isKnown = sequence.isHeld() &&
                             known.achieved_Pa.size() == result.points.size() &&
                             isSame(sequence.fields.front(), known.played);
        if (isKnown && !sequence.evened) return known.achieved_Pa;
        return haptics::achievedPressure(sequence, array, medium, options.threads, options.stop);
    };
    std::vector<Eigen::VectorXcf> planned = output.planned();
    if (isSilent(planned))
    {
        result.achieved_Pa.setZero(result.points.size());
        if (sequence.evened && planned.empty() && sequence.report.capFactor > 0.0)
            haptics::rateLevel(result.points,
                               achieved_Pa(std::vector<Eigen::VectorXcf>(sequence.fields)),
                               sequence.report);
        else if (sequence.report.capFactor < 1.0 || !planned.empty())
            ratePlayed(result);
        if (!planned.empty()) sequence.fields = std::move(planned);
        return false;
    }
    // The report rates the field as planned: a device that is late or gone changes only the
    // achieved pressures.
    std::vector<Eigen::VectorXcf> played = output.played();
    const bool asPlanned = played == planned;
    // Not rated yet: the felt field of an evened cycle, and a field lowered by a pressure cap or by
    // the device's amplitude cap.
    if (!isRated || sequence.evened || sequence.report.capFactor < 1.0 ||
        isLowered(planned, sequence.fields))
    {
        result.achieved_Pa = achieved_Pa(std::move(planned));
        ratePlayed(result);
        if (asPlanned) return true;
    }
    result.achieved_Pa = achieved_Pa(std::move(played));
    return true;
}

} // namespace midair::bridge
