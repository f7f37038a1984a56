#include "engine-bridge/c/inside/Field.h"

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/extending/OwnSolver.h"
#include "engine-bridge/player/SceneSolve.h"
#include "engine-bridge/playing/PressureCap.h"
#include "engine-bridge/solving/ArrayLevels.h"
#include "engine-bridge/solving/OneSolve.h"
#include "haptics/base/threads/Forks.h"
#include "haptics/propagation/Exposure.h"

#include <algorithm>

namespace midair::capi
{

namespace
{

void addExposure(const haptics::ExposureFigures& exposure,
                 std::vector<std::pair<std::string, double>>& figures)
{
    for (const haptics::ExposureRow& row : haptics::kExposureFigures)
        std::visit(
            [&](auto member)
            {
                figures.emplace_back(std::string("exposure.") + row.name,
                                     static_cast<double>(exposure.*member));
            },
            row.value);
}

/// Exposure at places around an array. Making it takes much longer than a query, and consecutive
/// queries mostly use the same array and air.
struct Listening
{
    base::Mutex mutex;
    std::weak_ptr<const haptics::TransducerArray> array MIDAIR_GUARDED_BY(mutex);
    haptics::Medium medium MIDAIR_GUARDED_BY(mutex);
    Eigen::Matrix3Xd ears MIDAIR_GUARDED_BY(mutex);
    std::unique_ptr<haptics::Exposure> exposure MIDAIR_GUARDED_BY(mutex);
};

haptics::ExposureFigures exposureOf(const Field& field)
{
    // Never destroyed, so that no thread meets it destroyed at the program's end, and no child of a
    // fork meets it locked.
    static auto* const all =
        new base::OfProcess<Listening>([](bool) { return std::make_unique<Listening>(); });
    Listening* const last = &**all;
    const base::Lock lock(last->mutex);
    const bool isKnown = last->exposure && last->array.lock() == field.array &&
                         last->medium == field.medium && last->ears.cols() == field.ears.cols() &&
                         last->ears == field.ears;
    if (!isKnown)
    {
        last->exposure = std::make_unique<haptics::Exposure>(
            *field.array, field.medium, bridge::placesHeard(*field.array, field.ears));
        last->array = field.array;
        last->medium = field.medium;
        last->ears = field.ears;
    }
    return bridge::steadyExposure(*last->exposure, field.sequence.fields, field.earLimit_dB);
}

} // namespace

const std::vector<std::pair<std::string, double>>& Field::figures() const
{
    std::call_once(_measured,
                   [this]
                   {
                       auto all = haptics::figuresOf(sequence.report);
                       all.emplace_back(kFingertipForce, fingertip().force_N);
                       addExposure(exposureOf(*this), all);
                       _figures = std::move(all);
                   });
    return _figures;
}

haptics::FingertipForce Field::fingertip() const
{
    if (felt) return *felt;
    haptics::FingertipForce force =
        haptics::strongestForce(points, achieved_Pa, *array, medium, sequence);
    force.threshold_N = feelThreshold_N;
    return force;
}

void Field::complete()
{
    info.transducers = static_cast<std::uint32_t>(array->size());
    info.fields = static_cast<std::uint32_t>(sequence.fields.size());
    info.points = static_cast<std::uint32_t>(points.size());
    info.rate_Hz = sequence.fields.size() > 1 ? sequence.modulation.fieldRate_Hz : 0.0;
}

bool findFigure(const std::vector<std::pair<std::string, double>>& all,
                const std::string& name,
                double& value)
{
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const auto& figure) { return figure.first == name; });
    if (found == all.end()) return false;
    value = found->second;
    return true;
}

Handles<midair_field, const Field>& fields()
{
    static auto* const all = new Handles<midair_field, const Field>("midair_field");
    return *all;
}

void failUnsolved(const std::string& solver, const std::string& why)
{
    fail(bridge::isOwnSolver(solver) ? MIDAIR_FAILED : MIDAIR_REFUSED, why);
}

void requireSolved(const haptics::SolveReport& report)
{
    if (report.stop == haptics::StopReason::REFUSED) failUnsolved(report.solver, report.message);
}

bool isSilence(const Field& field)
{
    return bridge::isSilent(field.sequence.fields);
}

midair_status soundsOrWhy(const Field& field)
{
    if (!isSilence(field)) return MIDAIR_OK;
    return silentFor(field.sequence.report.message);
}

std::shared_ptr<Field> fieldOf(const bridge::HologramResult& result,
                               const std::vector<midair_object>& objects)
{
    if (!result.array || result.sequence.fields.empty()) return nullptr;
    auto field = std::make_shared<Field>();
    field->array = result.array;
    field->drive = result.array->drive;
    bridge::keepToSignal(field->drive);
    field->medium = result.medium;
    field->sequence = result.sequence;
    field->points = result.points;
    field->achieved_Pa = result.achieved_Pa.cast<double>();
    field->achieved_Pa.conservativeResizeLike(Eigen::VectorXd::Zero(field->points.size()));
    const double largest = field->points.size() > 0 ? field->points.targets.maxCoeff() : 0.0;
    const double unit_Pa = field->points.absolute ? 1.0
                           : largest > 0.0        ? result.report().level_Pa / largest
                                                  : 0.0;
    field->wanted_Pa = unit_Pa * field->points.targets;
    field->objects = objects;
    field->felt = result.fingertip;
    bool sounds = false;
    for (const Eigen::VectorXcf& q : field->sequence.fields)
    {
        device::encode(q.data(), static_cast<int>(q.size()), field->signals.emplace_back());
        sounds = sounds || !q.isZero(0.0F);
    }
    field->complete();
    field->info.frame = result.frame;
    field->info.latency_ms = result.latency_ms;
    field->info.playing = result.playing && result.deviceOpen && sounds ? 1 : 0;
    return field;
}

} // namespace midair::capi
