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

/// Passes on what the kit and OpenSceneGraph say, on any thread, and counts lines that say the same
/// twice within a second: of these an exhibition's journal would be full.
class SaidLines : public osg::NotifyHandler
{
public:
    void notify(osg::NotifySeverity severity, const char* message) override;

    std::uint64_t count() const;
    /// Returns lines, without their numbers, that came more than once a second, and how often at
    /// the most.
    std::map<std::string, std::uint64_t> tooOften() const;

private:
    mutable base::Mutex _mutex;
    std::uint64_t _count MIDAIR_GUARDED_BY(_mutex) = 0;
    double _begin_s MIDAIR_GUARDED_BY(_mutex) = 0.0; ///< of the second that is counted in
    std::map<std::string, std::uint64_t> _second MIDAIR_GUARDED_BY(_mutex);
    std::map<std::string, std::uint64_t> _tooOften MIDAIR_GUARDED_BY(_mutex);
};

/// Counts what an installation did, frame by frame, for report.json, and looks for what an
/// exhibition must not have: memory that grows, messages over and over, sound where it must be
/// silent. Its own memory doesn't grow with time.
class InstallationRecord
{
public:
    InstallationRecord();

    /// What the shell knows of a frame.
    struct Frame
    {
        double now_s = 0.0; ///< steady clock
        bool isMuted = false;
        bool mustRest = false; ///< nobody is there
    };

    void addFrame(const Frame& frame, const osgMidair::HapticStatistics& now);
    /// Looks at the newest field; null: there is none.
    void addField(const osgMidair::HapticField* field);
    void addTouch(const osgMidair::Touch& touch);
    void addStroke(const osgMidair::Touch& touch);
    void addPicture(const std::string& file) { _pictures.push_back(file); }

    /// Returns the figures, without those of the installation.
    nlohmann::ordered_json figures(const osgMidair::HapticStatistics& end) const;
    /// Prints some of them, and the messages.
    void print(const std::string& program, const osgMidair::HapticStatistics& end) const;

private:
    /// How long a device may take to fall silent before that is counted.
    static constexpr double kGrace_s = 0.5;

    /// Frames that had to be silent, and those of them that played all the same.
    struct Silence
    {
        double since_s = -1.0;
        std::uint64_t frames = 0;
        std::uint64_t played = 0;

        void add(bool isAsked, bool isPlaying, double now_s);
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
    double _force_N = 0.0;     ///< the largest
    double _pressure_Pa = 0.0; ///< the largest at a control point, in the model
    osg::ref_ptr<const osgMidair::HapticField> _newest;
    double _begin_s = -1.0;
    double _end_s = 0.0;
    double _looked_s = -1e9;
    Silence _muted;
    Silence _alone;
    osg::ref_ptr<SaidLines> _said; ///< from now on, of the whole program
    Memory _memory_MB;
    std::vector<std::string> _pictures;
};

/// Returns the memory that this process has in RAM, MB; 0 if it isn't known.
double residentMemory_MB();

} // namespace midair::samples
