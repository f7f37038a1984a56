#pragma once

#include <cstdint>

namespace midair::device::emulation
{

/// Times of the emulation in nanoseconds: cable time (a test's clock, or the steady clock) and
/// readings of the units' clocks.
using Time_ns = std::int64_t;

constexpr Time_ns kMillisecond_ns = 1'000'000;
constexpr Time_ns kPeriod_ns = 25'000; ///< of the ultrasound, 40 kHz
constexpr Time_ns kNever_ns = INT64_MAX;

/// A clock with constant rate: it read reading_ns at cable time set_ns, and gains rate_ppm.
struct EmulatedClock
{
    Time_ns set_ns = 0;
    Time_ns reading_ns = 0;
    std::int64_t rate_ppm = 0; ///< magnitude at most 1000, so that no product overflows within a
                               ///< year

    Time_ns at(Time_ns now_ns) const
    {
        const Time_ns passed_ns = now_ns - set_ns;
        // Split, because the product of both overflows after some months.
        return reading_ns + passed_ns + passed_ns / 1'000'000 * rate_ppm +
               passed_ns % 1'000'000 * rate_ppm / 1'000'000;
    }
    /// First cable time at which it reads \a reading or more.
    Time_ns when(Time_ns reading) const
    {
        if (reading == kNever_ns || reading > at(set_ns) + kNever_ns / 4) return kNever_ns;
        Time_ns guess_ns = set_ns + (reading - reading_ns) -
                           static_cast<Time_ns>(static_cast<double>(reading - reading_ns) *
                                                static_cast<double>(rate_ppm) * 1e-6);
        for (int i = 0; i < 4 && at(guess_ns) != reading; ++i)
            guess_ns += reading - at(guess_ns);
        while (at(guess_ns) < reading)
            ++guess_ns;
        return guess_ns;
    }
    /// Continues from its reading at \a now_ns with another rate.
    void setRate(Time_ns now_ns, std::int64_t ppm)
    {
        set(now_ns, at(now_ns));
        rate_ppm = ppm;
    }
    void set(Time_ns now_ns, Time_ns reading)
    {
        set_ns = now_ns;
        reading_ns = reading;
    }
};

} // namespace midair::device::emulation
