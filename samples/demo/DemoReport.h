#pragma once

#include "samples/demo/DemoOptions.h"

#include <osgMidair/HapticStatistics>

#include <cstdint>
#include <string>
#include <vector>

namespace midair::bridge
{
struct HologramResult;
}

namespace midair::samples
{

/// One picture that was written, and how well its parts belong together.
struct DemoPicture
{
    std::string file;
    std::uint64_t frame = 0;      ///< whose pose is seen
    std::uint64_t fieldFrame = 0; ///< whose field is seen in the slice and played
    double latency_ms = 0.0;      ///< from that frame's stamp to the drive signal
    double peak_Pa = 0.0;         ///< the strongest spot of the slice ..
    double peakToPoint_mm = 0.0;  ///< .. and how far it is from the nearest control point
};

/// Figures of a run, gathered frame by frame: for report.json and for the ten lines at the end.
class DemoReport
{
public:
    /// A field that was not seen before is counted.
    void addFrame(double frame_ms, const bridge::HologramResult* newest);
    void addPicture(const DemoPicture& picture) { _pictures.push_back(picture); }

    /// \a path is replaced. False, with \a error, if it can't be written.
    bool write(const std::string& path, std::string& error) const;
    void print() const;

    std::string model;
    int transducers = 0;
    std::string array; ///< of the scene, whoever named it
    double temperature_C = 0.0;
    DemoOptions options;
    osgMidair::HapticStatistics statistics; ///< at the end
    double slice_ms = 0.0;
    double slicesPerSecond = 0.0;
    double seconds = 0.0;        ///< of the frames that ran freely
    std::string picturesProblem; ///< why there are none; empty: there are

private:
    std::vector<double> _frame_ms;
    std::vector<double> _solve_ms;
    std::vector<double> _rms;
    std::vector<double> _loudness;
    std::vector<double> _latency_ms;
    std::vector<DemoPicture> _pictures;
    std::uint64_t _lastField = 0;
};

/// The value below which the share \a quantile (0 .. 1) of \a values lies; 0 without any.
double quantile(std::vector<double> values, double share);

} // namespace midair::samples
