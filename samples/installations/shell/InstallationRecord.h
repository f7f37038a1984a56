#pragma once

#include "haptics/base/threads/Mutex.h"

#include <osgMidair/HapticField>
#include <osgMidair/HapticStatistics>
#include <osgMidair/TouchCallback>

#include <osg/Notify>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace midair::samples
{

/// Passes on notices of the kit and OpenSceneGraph from any thread, and counts lines that repeat
/// within a second, because they would fill an exhibition's log.
class SaidLines : public osg::NotifyHandler
{
public:
    void notify(osg::NotifySeverity severity, const char* message) override;

    std::uint64_t count() const;
    /// Returns lines, without their numbers, that came more than once in a second, with their
    /// largest number per second.
    std::map<std::string, std::uint64_t> tooOften() const;

private:
    mutable base::Mutex _mutex;
    std::uint64_t _count MIDAIR_GUARDED_BY(_mutex) = 0;
    double _begin_s MIDAIR_GUARDED_BY(_mutex) = 0.0; ///< start of the second being counted
    std::map<std::string, std::uint64_t> _second MIDAIR_GUARDED_BY(_mutex);
    std::map<std::string, std::uint64_t> _tooOften MIDAIR_GUARDED_BY(_mutex);
};

/// Counts what an installation does, frame by frame, for report.json, and detects problems at an
/// exhibition: growing memory, repeated messages, sound where it must be silent. Its own memory
/// doesn't grow with time.
class InstallationRecord
{
public:
    InstallationRecord();

    /// The shell's state of a frame.
    struct Frame
    {
        double now_s = 0.0; ///< steady clock
        bool isMuted = false;
        bool mustRest = false; ///< nobody is there
    };

    void addFrame(const Frame& frame, const osgMidair::HapticStatistics& now);
    /// Adds the newest field; may be null.
    void addField(const osgMidair::HapticField* field);
    /// \{ Adds a touch as felt() returns it.
    void addTouch(const osgMidair::Touch& touch);
    void addStroke(const osgMidair::Touch& touch);
    /// \}
    /// Returns \a touch with at most the force that a fingertip gets at the strongest place of the
    /// field of the last frame: the force of a touch is an upper estimate for a whole finger.
    osgMidair::Touch felt(osgMidair::Touch touch) const;
    void addPicture(const std::string& file) { _pictures.push_back(file); }

    /// Returns the figures, except those of the installation.
    nlohmann::ordered_json figures(const osgMidair::HapticStatistics& end) const;
    /// Prints a summary and the messages.
    void print(const std::string& program, const osgMidair::HapticStatistics& end) const;

private:
    /// time in which a device may fall silent
    static constexpr double kGrace_s = 0.5;

    /// Frames that had to be silent, and those that played nevertheless.
    struct Silence
    {
        double since_s = -1.0;
        std::uint64_t frames = 0;
        std::uint64_t played = 0;

        void add(bool isAsked, bool isPlaying, double now_s);
    };

    struct Most
    {
        double force_N = 0.0;     ///< of a touch
        double pressure_Pa = 0.0; ///< at a control point, computed
    };

    struct Memory
    {
        double first = 0.0; ///< after two minutes, or at the end
        double last = 0.0;
        double most = 0.0;
    };

    void look(double now_s);

    std::uint64_t _frames = 0;
    std::uint64_t _withHands = 0;
    std::uint64_t _playing = 0;
    std::uint64_t _touches = 0;
    Most _most;
    double _fingertip_N = 0.0; ///< at the strongest place, in the last frame
    osg::ref_ptr<const osgMidair::HapticField> _newest;
    double _begin_s = -1.0;
    double _end_s = 0.0;
    double _looked_s = -1e9;
    Silence _muted;
    Silence _alone;
    osg::ref_ptr<SaidLines> _said; ///< collects notices of the whole program
    Memory _memory_MB;
    std::vector<std::string> _pictures;
};

/// Returns the resident memory of this process, MB; 0 if unknown.
double residentMemory_MB();

} // namespace midair::samples
