#pragma once

#include <osgMidair/HapticScene>

#include <osg/Node>

#include <string>
#include <vector>

namespace midair::samples
{

/// In the order in which it is worse.
enum class Verdict
{
    OK,
    WARNING, ///< it is played, but hardly felt, or it could not be tried
    PROBLEM  ///< it isn't felt, or not as it was asked for
};

/// What midair-check was asked for.
struct CheckOptions
{
    std::string file;     ///< scene or model, as osgviewer would read it
    std::string settings; ///< file of settings, as for osgviewer's --device; empty: none
    std::string options;  ///< option string, as for osgviewer's -O
    int frames = 30;      ///< 1 .. 100000, at 60 a second of the scene's time
    double wait_s = 20.0; ///< > 0; longest wait for the field of one frame
};

/// An object at one of its places, as it was in the last frame.
struct CheckedObject
{
    std::string path;
    std::string name; ///< of the node
    osgMidair::HapticProperty property;
    bool hasShape = false;
    bool hasOwnPressures = false;           ///< a HapticPoints with a pressure for each point
    osgMidair::HapticField::Object leftOut; ///< numbers of points that are not felt
    int points = 0;                         ///< control points
    osg::Vec3d centre_m;                    ///< of the points' box, array frame; 0 without points
    osg::Vec3d size_m;                      ///< of that box
    double wanted_Pa = 0.0;                 ///< largest
    double lowestShare = 1.0; ///< smallest and mean of what is played over what is wanted
    double meanShare = 1.0;
    double lowest_Pa = 0.0; ///< weakest point, as played
    double mean_Pa = 0.0;
    double highest_Pa = 0.0;
    int feltFrames = 0; ///< frames in which it had control points
    int touchFrames = 0;
    double size_units = 0.0; ///< its largest extent, in its own units
    double force_N = 0.0;    ///< on a fingertip, the most at those of its points that were tried
    std::string feeling;     ///< of that: "faint" ..; empty: it has no points
    /// Sentences: what keeps it from being felt as it is asked for, what makes it hard to feel or
    /// could not be tried, and what is told besides.
    std::vector<std::string> faults;
    std::vector<std::string> warnings;
    std::vector<std::string> notes;

    Verdict verdict() const;
};

/// A message of a scene, of the reader of its file or of OSG.
struct CheckedMessage
{
    osgMidair::HapticMessage message;
    std::string file; ///< empty: not known
    int line = 0;     ///< from 1; 0: not known
};

/// A HapticScene after its frames. Scenes inside another one are played by that.
struct CheckedScene
{
    std::string name;
    osgMidair::HapticSettings asked;   ///< by the file, options and program
    osgMidair::HapticSettings granted; ///< what would be played
    osgMidair::HapticStatistics statistics;
    bool isInside = false; ///< another scene plays it
    std::string hiddenBy;  ///< what keeps a viewer from coming to it; empty: nothing
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
    std::string wrapped; ///< what was added to the file's scene so that it plays; empty: nothing
    int frames = 0;
    std::vector<CheckedScene> scenes;
    std::vector<CheckedMessage> reading; ///< from OSG and its readers

    Verdict verdict() const;
    /// A sentence: what the verdict is for, the root cause first.
    std::string because() const;
    /// The whole command that mends it; empty: none is known.
    std::string remedy() const;
    /// 1 for a PROBLEM, else 0.
    int exitCode() const { return verdict() == Verdict::PROBLEM ? 1 : 0; }
};

/// Plays a scene file without a window and without hardware, and collects what is felt. Throws
/// std::runtime_error if the file can't be read.
CheckResult checkScene(const CheckOptions& options);

/// "OK", "WARNING" or "PROBLEM".
const char* verdictName(Verdict verdict);

/// Adds faults, warnings and notes to an object of \a scene from its numbers.
void judge(CheckedObject& object, const CheckedScene& scene, int frames);

/// Says why a scene without any object is not felt.
std::string whyNothing(const CheckedScene& scene);

/// "500 Pa", "1 (relative)" "a pressure for each point" or "what isn't understood".
std::string pressureText(const CheckedObject& object);

} // namespace midair::samples
