#pragma once

#include "samples/tools/sense/SenseOutput.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace midair::samples
{

/// On what a pattern is played, and how strongly.
struct SensePlaybackOptions
{
    std::string array = "octagon";
    std::string device = "sim:";
    std::string hands;           ///< source of hands; empty: none
    double pressure_Pa = 3000.0; ///< peak, at intensity 1
    std::uint64_t seed = 1;      ///< of random intensities
    /// m, in the array's frame: the point of patternPlace(); none: as that says
    std::optional<Eigen::Vector3d> place_m;
    /// m; of the pattern's own origin below that point: kPatternHeight_m for patterns that have
    /// their height in front of an array, 0 for those that have none
    double height_m = 0.0;
};

/// Plays a pattern on an array, by libmidair's functions for C. One thread, except for mute().
class SensePlayback : public SenseOutput
{
public:
    /// Begins to open the device; isOpening() tells when that is done. \a tell receives messages
    /// for the user. Throws InputError for an array, device or source of hands that can't be used.
    SensePlayback(const SensePlaybackOptions& options,
                  std::function<void(const std::string&)> tell);
    ~SensePlayback() override; ///< silences the device, then closes it

    void setSensation(const std::string& sensation) override;
    void setParameters(const SenseParameters& parameters) override;
    void setTransform(const Eigen::Matrix4d& transform) override;
    void setTracking(bool isTracking) override;
    void begin() override;
    void end() override;
    std::optional<SenseHand> hand() const override;
    void update(double time_s) override;

    bool isOpening() const;               ///< array and device are being opened
    bool isOpen() const;                  ///< false: it is being opened, or that has failed
    bool isWorking() const;               ///< false: the device is lost, at fault, or not open
    std::string status() const;           ///< a line about the device and what it has played
    const Eigen::Matrix4d& place() const; ///< of the point of patternPlace(), array frame

    /// Silences the array for good. Any thread; waits for nothing.
    void mute();

private:
    struct Scene;
    std::unique_ptr<Scene> _scene;
};

} // namespace midair::samples
