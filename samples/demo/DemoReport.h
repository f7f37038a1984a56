#pragma once

#include "samples/demo/DemoScene.h"

#include <osgMidair/HapticStatistics>

#include <cstdint>
#include <string>
#include <vector>

namespace midair::samples
{

/// A picture that was written, with data that show if its parts belong to the same frame.
struct DemoPicture
{
    std::string file;
    std::uint64_t frame = 0;      ///< frame of the pose that is shown
    std::uint64_t fieldFrame = 0; ///< frame of the field that is shown in the slice and played
    double latency_ms = 0.0;      ///< from that frame's stamp to the drive signal
    double peak_Pa = 0.0;         ///< maximum of the slice ..
    double peakToPoint_mm = 0.0;  ///< .. and its distance from the nearest control point
};

/// Collects figures of a run frame by frame, for report.json and for the ten lines at the end.
class DemoReport
{
public:
    /// Adds a frame, and once the figures of each new field in \a now.
    void addFrame(double frame_ms, const osgMidair::HapticStatistics& now);
    void addPicture(const DemoPicture& picture) { _pictures.push_back(picture); }

    /// Writes the report to \a path, replacing the file. Returns false, with \a error, if it can't
    /// be written.
    bool write(const std::string& path, std::string& error) const;
    void print() const;

    std::string model;
    int transducers = 0;
    std::string array; ///< array of the scene
    double temperature_C = 0.0;
    DemoOptions options;
    osgMidair::HapticStatistics statistics; ///< at the end
    double slice_ms = 0.0;
    double slicesPerSecond = 0.0;
    double seconds = 0.0;        ///< duration of the frames that ran at full speed
    std::string picturesProblem; ///< why there are no pictures; empty: there are

private:
    std::vector<double> _frame_ms;
    std::vector<double> _solve_ms;
    std::vector<double> _rms;
    std::vector<double> _loudness;
    std::vector<double> _latency_ms;
    std::vector<DemoPicture> _pictures;
    std::uint64_t _lastField = 0;
};

} // namespace midair::samples
