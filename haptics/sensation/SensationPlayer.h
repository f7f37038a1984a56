#pragma once

#include "haptics/sensation/SensationSample.h"
#include "haptics/sensation/SensationTrack.h"
#include "haptics/sensation/SensationValues.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

namespace midair::haptics
{

/// The highest frequencies that are played; higher ones are left out, so that nothing aliases.
struct SensationCarried
{
    double draw_Hz = std::numeric_limits<double>::infinity();
    double modulation_Hz = std::numeric_limits<double>::infinity();

    /// Those of \a rate_Hz fields a second, one by one; 0: any.
    static SensationCarried at(double rate_Hz);
};

/// Options of a player; any number is played.
struct SensationPlayerOptions
{
    double speed = 1.0;       ///< factor on the pattern's own speed; 0 holds the pattern
    std::uint64_t seed = 1;   ///< of random intensities
    bool dropsHeight = false; ///< leaves out the transform's translation along z, which only
                              ///< patterns in the array's frame need
};

/// What a pattern repeats without an end while its parameters and its speed stay.
struct SteadySensation
{
    Eigen::Vector3d path_mm = Eigen::Vector3d::Zero();
    double intensity = 0.0; ///< 0 .. 1, without the modulation
    DrawnBrush brush;
    double draw_turns = 0.0;       ///< where the brush is
    double modulation_turns = 0.0; ///< where the modulation is
};

/// Plays a pattern field by field. It differs from AdapTics (SensationEvaluator) where that depends
/// on the rate of fields or on a hand:
/// - Jumps are taken at multiples of kStep_ms, so loops don't depend on the rate of fields.
/// - Phases of the brush and the modulation integrate their frequencies, so these change without a
///   jump.
/// - Random intensities hold for kHold_ms, and repeat with the seed.
/// - The whole sample, brush included, is in the pattern's own frame, so that its user turns it as
///   one.
/// - Where fields come too slowly, nothing aliases: a brush with fewer than
///   SensationFigures::kLeastPoints fields a turn is an outline (SensationSample::isOutline), a
///   modulation with fewer than kLeastOfPeriod fields a period is left out.
/// - Intensities are limited to 0 .. 1. A pattern that has stopped is silent, and so is a sample
///   that isn't finite, which keeps its place.
class SensationPlayer
{
public:
    static constexpr double kStep_ms = 0.05; ///< 20 kHz, the rate of AdapTics' engine
    static constexpr double kHold_ms = 5.0;
    static constexpr double kLeastOfPeriod = 4.0;

    explicit SensationPlayer(std::shared_ptr<const Sensation> sensation,
                             const SensationPlayerOptions& options = {});

    const Sensation& sensation() const { return _track.sensation(); }
    /// Parameters may change between samples; changes apply to the time after the last sample.
    SensationValues& values() { return _values; }
    const SensationValues& values() const { return _values; }
    void setSpeed(double speed) { _options.speed = speed; }
    void setCarried(const SensationCarried& carried) { _carried = carried; }

    /// Returns the sample at \a time_ms since the start. Times should not descend; at an earlier
    /// one the pattern holds. After 20,000 jumps for one sample, those of a second, the rest of the
    /// time has none. Doesn't allocate.
    SensationSample sampleAt(double time_ms);

    /// Returns what follows the last sample for ever; none: the pattern moves, changes, is random,
    /// has stopped or isn't finite.
    std::optional<SteadySensation> steady() const;

    /// Begins anew at time 0. Parameters keep their values.
    void restart();
    /// Plays another pattern, or another version of this one, from the same time on. Parameters
    /// that both have keep their values.
    void replace(std::shared_ptr<const Sensation> sensation);

private:
    /// How far the pattern has come.
    struct Progress
    {
        double time_ms = 0.0;
        double pattern_ms = 0.0;
        double looked_ms = 0.0; ///< up to here keyframes were looked at for jumps
        double draw_turns = 0.0;
        double modulation_turns = 0.0;
    };

    void advance(double time_ms);
    void run(double until_ms, double speed);
    void turn(double passed_ms, double middle_ms);
    TrackPoint pointNow() const;

    SensationTrack _track;
    SensationValues _values;
    SensationPlayerOptions _options;
    SensationCarried _carried;
    Progress _now;
    double _shown_ms = 0.0; ///< time in the pattern; before a jump that is due
    bool _isBroken = false; ///< the speed isn't finite
    double _speed = 0.0;    ///< at the last sample
    Eigen::Vector3d _place_mm = Eigen::Vector3d::Zero(); ///< the last one that was finite
};

} // namespace midair::haptics
