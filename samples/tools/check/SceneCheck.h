#pragma once

#include <osgMidair/HapticScene>

#include <osg/Node>

#include <string>
#include <vector>

namespace midair::samples
{

/// A relative pressure above this was perhaps meant in Pa.
constexpr double kLargeRelative = 20.0;

/// In order of severity.
enum class Verdict
{
    OK,
    WARNING, ///< it is played, but is weak or could not be tested
    PROBLEM  ///< it can't be felt, or not as requested
};

/// Options of midair-check.
struct CheckOptions
{
    std::string file;     ///< scene or model, any file that osgviewer reads
    std::string settings; ///< file of settings, as for osgviewer's --device; empty: none
    std::string options;  ///< option string, as for osgviewer's -O
    int frames = 30;      ///< 1 .. 100000, at 60 a second of the scene's time
    double wait_s = 20.0; ///< > 0; longest wait for the field of one frame
};

/// An object at one of its places, as of the last frame.
struct CheckedObject
{
    std::string path;
    std::string name; ///< of the node
    osgMidair::HapticProperty property;
    bool hasShape = false;
    bool hasOwnPressures = false;           ///< a HapticPoints with a pressure for each point
    osgMidair::HapticField::Object leftOut; ///< number of points left out, by reason
    int points = 0;                         ///< control points
    osg::Vec3d centre_m;                    ///< of the points' box, array frame; 0 without points
    osg::Vec3d size_m;                      ///< of that box
    double wanted_Pa = 0.0;                 ///< largest target
    double lowestShare = 1.0; ///< smallest and mean ratio of played to wanted pressure
    double meanShare = 1.0;
    double lowest_Pa = 0.0; ///< weakest point, as played
    double mean_Pa = 0.0;
    double highest_Pa = 0.0;
    int feltFrames = 0; ///< frames in which it had a playing control point
    int touchFrames = 0;
    bool isSizeWrong = false; ///< it is too large, too small or in another unit
    bool isWeak = false;      ///< most people would not feel it
    double force_N = 0.0;     ///< largest force on a fingertip among the tested points
    std::string feeling;      ///< word for force_N: "faint" ..; empty: it has no points
    /// Sentences: faults (it can't be felt as requested), warnings (it is weak or could not be
    /// tested) and other notes.
    std::vector<std::string> faults;
    std::vector<std::string> warnings;
    std::vector<std::string> notes;

    Verdict verdict() const;
};

/// A message of a scene, of its file's reader or of OSG.
struct CheckedMessage
{
    osgMidair::HapticMessage message;
    std::string file; ///< empty: not known
    int line = 0;     ///< from 1; 0: not known
};

/// A HapticScene after the last frame. A scene inside another one is played by the outer scene.
struct CheckedScene
{
    std::string name;
    osgMidair::HapticSettings asked;   ///< settings from file, options and program
    osgMidair::HapticSettings granted; ///< settings that would be used
    osgMidair::HapticStatistics statistics;
    bool isInside = false; ///< it is inside another scene, which plays it
    std::string hiddenBy;  ///< what hides it from a viewer; empty: nothing
    int transducers = 0;
    osg::Vec3d arraySize_m;
    double reach_m = 0.0;
    std::vector<CheckedObject> objects;
    std::vector<CheckedMessage> messages;
};

struct CheckResult
{
    std::string file;
    std::string options; ///< as CheckOptions has them
    std::string wrapped; ///< what was added to the file's scene to make it play; empty: nothing
    int frames = 0;
    std::vector<CheckedScene> scenes;
    std::vector<CheckedMessage> reading; ///< from OSG, its readers and about options
    double width_m = 0.0;                ///< of the whole file
    std::string remedy; ///< complete command that fixes the problem, tried; empty: none is known

    Verdict verdict() const;
    /// Returns the reason for the verdict as a sentence, the root cause first.
    std::string because() const;
    /// 1 for a PROBLEM, else 0.
    int exitCode() const { return verdict() == Verdict::PROBLEM ? 1 : 0; }
};

/// Plays a scene file without a window and without hardware and collects the results. Throws
/// std::runtime_error if the file can't be read.
CheckResult checkScene(const CheckOptions& options);

/// "OK", "WARNING" or "PROBLEM".
const char* verdictName(Verdict verdict);

/// Derives faults, warnings and notes of an object of \a scene from its numbers.
void judge(CheckedObject& object, const CheckedScene& scene, int frames);

/// Returns why a scene without objects plays nothing.
std::string whyNothing(const CheckedScene& scene);

/// Returns "500 Pa", "1, relative to the other objects", "a pressure for each point" or "an invalid
/// value".
std::string pressureText(const CheckedObject& object);

} // namespace midair::samples
