#include "device/limits/UserLimits.h"

#include "device/DeviceUri.h"
#include "device/limits/GuardedDevice.h"
#include "haptics/base/Limits.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Range.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace midair::device
{

namespace
{

constexpr const char* kEnabled = "OSG_MIDAIR_ENABLED";
constexpr const char* kMaxAmplitude = "OSG_MIDAIR_MAX_AMPLITUDE";
constexpr const char* kMaxPressure = "OSG_MIDAIR_MAX_PRESSURE";
constexpr const char* kEarLimit = "OSG_MIDAIR_EAR_LIMIT";
constexpr const char* kEarPoints = "OSG_MIDAIR_EAR_POINTS";

/// Lets \a read parse each value of the variable \a name into separate caps, which then restrict \a
/// caps. \a read returns false on an error; \a expected describes valid values.
template<typename Read>
void readCap(UserCaps& caps, const char* name, const std::string& expected, Read read)
{
    const auto atBegin = base::userVariable(name);
    auto now = base::variableNow(name);
    if (now == atBegin) now.reset();
    for (const auto& text : {atBegin, now})
        if (UserCaps one; text && read(*text, one))
            caps = stricter(std::move(caps), one);
        else if (text)
            caps.wrong.push_back(fmt::format(
                "{} is \"{}\", should be {}; nothing is played", name, *text, expected));
}

/// Parses a number in 0 .. \a most.
bool readNumber(const std::string& text, const char* unit, double most, double& value)
{
    return base::parseQuantity(text, unit, value) && value >= 0 && value <= most;
}

/// Parses "110", "110 dB", "none", "0".
bool readLevel(const std::string& text, double& level_dB)
{
    if (base::lowerCase(base::trimmed(text)) == "none")
        level_dB = 0;
    else if (!readNumber(text, "dB", base::kMostEarLimit_dB, level_dB))
        return false;
    return level_dB == 0 || level_dB >= base::kLeastEarLimit_dB;
}

} // namespace

bool operator==(const UserCaps& a, const UserCaps& b)
{
    return a.maxAmplitude == b.maxAmplitude && a.maxPressure_Pa == b.maxPressure_Pa &&
           a.earLimit_dB == b.earLimit_dB && a.earPoints == b.earPoints &&
           a.isEarLimitChosen == b.isEarLimitChosen && a.isSilencing == b.isSilencing &&
           a.wrong == b.wrong;
}

const std::vector<std::string>& userCapVariables()
{
    static const std::vector<std::string> all = {
        kEnabled, kMaxAmplitude, kMaxPressure, kEarLimit, kEarPoints};
    return all;
}

std::string joinedPlaces(const std::string& a, const std::string& b)
{
    const std::string first = base::trimmed(a);
    const std::string second = base::trimmed(b);
    if (first.empty() || second.empty() || first == second) return first.empty() ? b : a;
    return first + (first.back() == ';' ? " " : "; ") + second;
}

UserCaps stricter(UserCaps a, const UserCaps& b)
{
    a.maxAmplitude = std::min(a.maxAmplitude, b.maxAmplitude);
    a.maxPressure_Pa = stricterCap(a.maxPressure_Pa, b.maxPressure_Pa);
    a.earLimit_dB = stricterCap(a.earLimit_dB, b.earLimit_dB);
    a.earPoints = joinedPlaces(a.earPoints, b.earPoints);
    a.isEarLimitChosen = a.isEarLimitChosen || b.isEarLimitChosen;
    a.isSilencing = a.isSilencing || b.isSilencing;
    a.wrong.insert(a.wrong.end(), b.wrong.begin(), b.wrong.end());
    return a;
}

UserCaps capsOfUser()
{
    UserCaps caps;
    readCap(caps,
            kEnabled,
            "true or false",
            [](const std::string& text, UserCaps& one)
            {
                bool isEnabled = false;
                const bool isRead = base::parseYesNo(text, isEnabled);
                one.isSilencing = !isEnabled;
                return isRead;
            });
    readCap(caps,
            kMaxAmplitude,
            "a number, 0 .. 1",
            [](const std::string& text, UserCaps& one)
            { return readNumber(text, "", 1, one.maxAmplitude); });
    readCap(caps,
            kMaxPressure,
            fmt::format("a number, 0 .. {:g} Pa", base::kMostPressure_Pa),
            [](const std::string& text, UserCaps& one)
            { return readNumber(text, "Pa", base::kMostPressure_Pa, one.maxPressure_Pa); });
    readCap(caps,
            kEarLimit,
            fmt::format("none, or a number, {:g} .. {:g} dB",
                        base::kLeastEarLimit_dB,
                        base::kMostEarLimit_dB),
            [](const std::string& text, UserCaps& one)
            { return one.isEarLimitChosen = readLevel(text, one.earLimit_dB); });
    readCap(caps,
            kEarPoints,
            base::kPlacesExpected,
            [&](const std::string& text, UserCaps& one)
            {
                std::vector<std::array<double, 3>> places;
                one.earPoints = text;
                return base::parsePlaces(joinedPlaces(caps.earPoints, text), places);
            });
    return caps;
}

void checkLimits(const SafetyLimits& limits)
{
    std::string error;
    const bool good =
        base::RangeCheck("device limits: ")
            .within("maxAmplitude", limits.maxAmplitude, 0, 1)
            .within("ramp", limits.ramp_s, 0, 10, " s")
            .within("meanDrive", limits.meanDrive, 0, 1)
            .above("meanDriveTime", limits.meanDriveTime_s, 0, " s")
            .atLeast("hold", limits.hold_s, 0, " s")
            .within("maxPressure", limits.maxPressure_Pa, 0, base::kMostPressure_Pa, " Pa")
            .passed(&error);
    if (!good) throw DeviceError(error);
}

SafetyLimits takeLimits(DeviceUri& uri, const SafetyLimits& limits)
{
    SafetyLimits strict = limits;
    strict.maxAmplitude = std::min(limits.maxAmplitude, uri.takeNumber("max-amplitude", 1, 0, 1));
    strict.ramp_s = std::max(limits.ramp_s, uri.takeSeconds("ramp", 0));
    strict.meanDrive = std::min(limits.meanDrive, uri.takeNumber("mean-drive", 1, 0, 1));
    strict.meanDriveTime_s = uri.takeSeconds("mean-drive-time", limits.meanDriveTime_s);
    strict.maxPressure_Pa = stricterCap(
        limits.maxPressure_Pa, uri.takeNumber("max-pressure", 0, 1, base::kMostPressure_Pa));
    const double hold_s = uri.takeSeconds("hold", 0);
    if (hold_s > 0) strict.hold_s = limits.hold_s > 0 ? std::min(limits.hold_s, hold_s) : hold_s;
    return strict;
}

double stricterCap(double a, double b)
{
    return a > 0 && b > 0 ? std::min(a, b) : std::max(a, b);
}

} // namespace midair::device
