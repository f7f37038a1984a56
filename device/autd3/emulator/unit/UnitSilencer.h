#pragma once

#include "device/autd3/emulator/unit/EmulatedClock.h"

#include <array>
#include <cstdint>

namespace midair::device::emulation
{

constexpr int kUnitTransducers = 249;
using UnitLevels = std::array<std::uint8_t, kUnitTransducers>;

/// Phases and intensities of a unit as its memory has them.
struct UnitPattern
{
    UnitLevels phase{};
    UnitLevels intensity{};

    bool operator==(const UnitPattern& other) const
    {
        return phase == other.phase && intensity == other.intensity;
    }
};

/// Lets phases (the short way round) and intensities glide, period by period.
class UnitSilencer
{
public:
    /// How values glide: in so many periods, or by so many 1/256 levels a period.
    struct Settings
    {
        bool byRate = false;
        bool strict = false;
        std::uint16_t rateIntensity = 256;
        std::uint16_t ratePhase = 256;
        std::uint16_t stepsIntensity = 10;
        std::uint16_t stepsPhase = 40;
    };

    void set(const Settings& settings) { _settings = settings; }
    const Settings& settings() const { return _settings; }

    void head(const UnitPattern& target); ///< begins to glide there
    void jump(const UnitPattern& target); ///< is there
    void glide(Time_ns periods);          ///< lets so many periods pass

    float phase(int transducer) const { return _phase[transducer].value; }
    float intensity(int transducer) const { return _intensity[transducer].value; }

private:
    /// One value on its way.
    struct Gliding
    {
        float value = 0;
        float target = 0; ///< of phases the turn of it that is nearest to value
        float step = 0;
        int left = 0; ///< periods, where it goes by steps

        void headFor(float next, int steps);
        void pass(Time_ns periods, bool byRate, float rate);
    };

    Settings _settings;
    std::array<Gliding, kUnitTransducers> _phase{};
    std::array<Gliding, kUnitTransducers> _intensity{};
};

} // namespace midair::device::emulation
