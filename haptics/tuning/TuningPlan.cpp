#include "haptics/tuning/TuningPlan.h"

#include "haptics/array/Medium.h"
#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

// Silent rows a place: their mean is what leaks from the drive into the microphone, their spread
// the noise.
constexpr int kSilentRows = 16;
// Transducers of a reference. Half of them may be reversed, so that their sum is about 4 times one
// of them, and less than half of one in 1.6 % of all arrays.
constexpr int kReference = 16;
// Rows of a reference alone.
constexpr int kAlone = 4;
// The check: foci up to this far from the microphone along each axis, in steps. The paper's focus
// is 4 to 9 mm wide, that of a board 10 mm across and some 30 mm deep.
constexpr double kFocusReach_m = 24e-3;
constexpr double kFocusStep_m = 1.5e-3;
constexpr int kFocusSingles = 48;

void silence(TuningPlan& plan, int place, int count)
{
    for (int k = 0; k < count; ++k)
    {
        TuningRow row;
        row.place = place;
        plan.rows.push_back(row);
    }
}

void planSingle(TuningPlan& plan, int place, int dutyLevel)
{
    silence(plan, place, kSilentRows);
    for (int i = 0; i < plan.transducers; ++i)
    {
        if (plan.isOff(i)) continue;
        TuningRow row;
        row.place = place;
        row.element = i;
        row.dutyLevel = dutyLevel;
        plan.rows.push_back(row);
    }
}

void planHadamard(TuningPlan& plan, int place, int dutyLevel)
{
    for (int r = 0; r < plan.order(); ++r)
    {
        TuningRow row;
        row.place = place;
        row.element = r;
        row.dutyLevel = dutyLevel;
        plan.rows.push_back(row);
    }
}

bool isReference(const TuningRow& row, int element)
{
    return row.referenceStep > 0 && element >= row.referenceFirst &&
           (element - row.referenceFirst) % row.referenceStep == 0;
}

void planLevels(TuningPlan& plan, int place, int dutyLevel)
{
    const int step = std::max(2, plan.transducers / kReference);
    TuningRow first;
    first.place = place;
    first.referenceStep = step;
    TuningRow second = first;
    second.referenceFirst = step / 2;
    silence(plan, place, kSilentRows);
    for (TuningRow row : {first, second})
    {
        row.referenceDutyLevel = dutyLevel;
        plan.rows.insert(plan.rows.end(), kAlone, row);
    }
    for (int i = 0; i < plan.transducers; ++i)
    {
        if (plan.isOff(i)) continue;
        TuningRow row = isReference(first, i) ? second : first;
        row.element = i;
        row.dutyLevel = row.referenceDutyLevel = dutyLevel;
        for (int quarter = 0; quarter < 4; ++quarter)
        {
            row.phaseLevel = 64 * quarter;
            plan.rows.push_back(row);
        }
    }
}

void planFocus(TuningPlan& plan, int place, int dutyLevel)
{
    silence(plan, place, kSilentRows);
    std::vector<int> live;
    for (int i = 0; i < plan.transducers; ++i)
        if (!plan.isOff(i)) live.push_back(i);
    const auto count = std::min<std::size_t>(kFocusSingles, live.size());
    for (std::size_t k = 0; k < count; ++k)
    {
        TuningRow row;
        row.place = place;
        row.element = live[k * live.size() / count];
        row.dutyLevel = dutyLevel;
        plan.rows.push_back(row);
    }
    const int reach = static_cast<int>(std::lround(kFocusReach_m / kFocusStep_m));
    for (int axis = 0; axis < 3; ++axis)
        for (int step = -reach; step <= reach; ++step)
        {
            TuningRow row;
            row.place = place;
            row.element = -1;
            row.dutyLevel = dutyLevel;
            row.focus = plan.places.col(place) + step * kFocusStep_m * Eigen::Vector3d::Unit(axis);
            plan.rows.push_back(row);
        }
}

void checkPlaces(const TransducerArray& array, const Eigen::Matrix3Xd& places)
{
    if (places.cols() < 1) throw base::InputError("there is no place of a microphone");
    for (Eigen::Index p = 0; p < places.cols(); ++p)
    {
        if (!places.col(p).allFinite())
            throw base::InputError(
                fmt::format("place {} of the microphone is not three finite numbers", p));
        const double nearest_m =
            (array.positions.colwise() - places.col(p)).colwise().norm().minCoeff();
        if (nearest_m < kNearestDistance_m)
            throw base::InputError(fmt::format(
                "place {} of the microphone is {:.1f} mm from a transducer; it must be {:.0f} or "
                "more",
                p,
                1e3 * nearest_m,
                1e3 * kNearestDistance_m));
    }
}

// q_i = e^{j(k |f - r_i| - offset_i)}: all waves arrive at f with the same phase. Gains are left
// alone: the loudest focus has every transducer at the same drive.
void focusOn(const TuningPlan& plan,
             const TuningRow& row,
             const TransducerArray& array,
             TuningDrive& drive)
{
    const double k = base::kTwoPi * array.frequency_Hz / plan.soundSpeed_m_s;
    for (int i = 0; i < plan.transducers; ++i)
    {
        const auto at = static_cast<std::size_t>(i);
        const bool isDead = array.gain.size() > 0 && array.gain[i] == 0.0;
        if (plan.isOff(i) || isDead) continue;
        const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0.0;
        const double turns =
            (k * (row.focus - array.positions.col(i)).norm() - offset) / base::kTwoPi;
        drive.phase[at] = static_cast<std::uint8_t>(std::lround(256.0 * turns) & 255);
        drive.duty[at] = static_cast<std::uint8_t>(row.dutyLevel);
    }
}

bool isNegative(int row, int element)
{
    bool odd = false;
    for (unsigned bits = static_cast<unsigned>(row) & static_cast<unsigned>(element + 1); bits != 0;
         bits &= bits - 1)
        odd = !odd;
    return odd;
}

} // namespace

const char* tuningMethodName(TuningMethod method)
{
    switch (method)
    {
    case TuningMethod::SINGLE:
        return "single";
    case TuningMethod::HADAMARD:
        return "hadamard";
    case TuningMethod::LEVELS:
        return "levels";
    case TuningMethod::FOCUS:
        break;
    }
    return "focus";
}

bool TuningPlan::isOff(int element) const
{
    return std::binary_search(off.begin(), off.end(), element);
}

int TuningPlan::order() const
{
    int order = 1;
    while (order <= transducers)
        order *= 2;
    return order;
}

TuningPlan makeTuningPlan(const TransducerArray& array, const TuningPlanOptions& options)
{
    checkPlaces(array, options.places);
    Medium medium;
    medium.temperature_C = options.temperature_C;
    std::string error;
    if (!medium.isValid(&error)) throw base::InputError("the air's " + error);
    if (options.dutyLevel < 1 || options.dutyLevel > 255)
        throw base::InputError(
            fmt::format("duty level is {}; it must be within 1 .. 255", options.dutyLevel));
    TuningPlan plan;
    plan.method = options.method;
    plan.array = array.name;
    plan.transducers = array.size();
    plan.soundSpeed_m_s = medium.soundSpeed();
    plan.off = array.dead;
    plan.places = options.places;
    if (static_cast<int>(plan.off.size()) == plan.transducers)
        throw base::InputError("all transducers of array '" + array.name + "' are dead");
    for (int place = 0; place < static_cast<int>(plan.places.cols()); ++place)
        switch (options.method)
        {
        case TuningMethod::SINGLE:
            planSingle(plan, place, options.dutyLevel);
            break;
        case TuningMethod::HADAMARD:
            planHadamard(plan, place, options.dutyLevel);
            break;
        case TuningMethod::LEVELS:
            planLevels(plan, place, options.dutyLevel);
            break;
        case TuningMethod::FOCUS:
            planFocus(plan, place, options.dutyLevel);
            break;
        }
    return plan;
}

TuningDrive driveOf(const TuningPlan& plan, const TuningRow& row, const TransducerArray* array)
{
    const auto m = static_cast<std::size_t>(plan.transducers);
    TuningDrive drive{std::vector<std::uint8_t>(m, 0), std::vector<std::uint8_t>(m, 0)};
    const auto duty = static_cast<std::uint8_t>(row.dutyLevel);
    if (plan.method == TuningMethod::FOCUS && row.element < 0)
    {
        if (array == nullptr) throw base::InputError("a plan of foci needs the tuned array");
        focusOn(plan, row, *array, drive);
        return drive;
    }
    for (int i = 0; i < plan.transducers; ++i)
    {
        const auto at = static_cast<std::size_t>(i);
        if (plan.isOff(i)) continue;
        if (plan.method == TuningMethod::HADAMARD)
        {
            drive.duty[at] = duty;
            drive.phase[at] = isNegative(row.element, i) ? 128 : 0;
        }
        else if (i == row.element)
        {
            drive.duty[at] = duty;
            drive.phase[at] = static_cast<std::uint8_t>(row.phaseLevel);
        }
        else if (isReference(row, i))
            drive.duty[at] = static_cast<std::uint8_t>(row.referenceDutyLevel);
    }
    return drive;
}

} // namespace midair::haptics
