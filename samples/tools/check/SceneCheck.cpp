// What of the numbers of a check is a fault.
#include "samples/tools/check/SceneCheck.h"

#include "samples/shared/SettingOptions.h"
#include "samples/tools/check/LoadedScene.h"

#include <osgMidair/HapticPoints>

#include <osg/BoundingBox>
#include <osg/FrameStamp>
#include <osgUtil/UpdateVisitor>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <thread>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using osgMidair::HapticMessage;

/// Share of the pressure asked for, in Pa, below which an object counts as too weak.
constexpr double kWeakShare = 0.9;
/// A relative pressure above it was perhaps meant in Pa.
constexpr double kLargeRelative = 20.0;

bool isBad(const CheckedMessage& one)
{
    return one.message.severity != HapticMessage::NOTICE;
}

std::string points(unsigned int count, const char* why)
{
    return fmt::format("{} point{} left out: {}", count, count == 1 ? " is" : "s are", why);
}

/// Returns what was told of an object, without its path: messages with one of \a codes, or if there
/// are no codes, warnings and faults.
std::vector<std::string> toldOf(const CheckedObject& object,
                                const CheckedScene& scene,
                                const std::vector<std::string>& codes)
{
    const std::string path = object.path + ": ";
    std::vector<std::string> texts;
    for (const CheckedMessage& one : scene.messages)
    {
        const std::string& text = one.message.text;
        const bool isMeant =
            codes.empty() ? isBad(one)
                          : std::find(codes.begin(), codes.end(), one.message.code) != codes.end();
        if (isMeant && one.message.path == object.path && text.rfind(path, 0) == 0)
            texts.push_back(text.substr(path.size()));
    }
    return texts;
}

void append(std::vector<std::string>& all, const std::vector<std::string>& more)
{
    all.insert(all.end(), more.begin(), more.end());
}

bool isFeltByContact(const CheckedObject& object, const CheckedScene& scene)
{
    using Settings = osgMidair::HapticSettings;
    using Property = osgMidair::HapticProperty;
    const auto own = object.property.render;
    return own == Property::INHERIT ? scene.granted.render == Settings::CONTACT
                                    : own == Property::CONTACT;
}

/// Says why an object that is felt where hands touch it is felt in no frame.
void judgeUntouched(CheckedObject& object, const CheckedScene& scene)
{
    if (isRecording(scene.granted.hands))
        object.faults.push_back("it isn't felt: no hand of the recording touches it");
    else
        object.notes.push_back("it is felt where a hand touches it, which can't be tried: of hands "
                               "only recordings are read");
}

/// Says why an object is felt in no frame, in the words of the messages where there are some.
void judgeUnfelt(CheckedObject& object, const CheckedScene& scene)
{
    const osgMidair::HapticField::Object& out = object.leftOut;
    const std::vector<std::string> hidden = toldOf(object, scene, {"object.hidden"});
    const std::vector<std::string> told = toldOf(object, scene, {});
    const std::vector<std::string> tie = toldOf(object, scene, {"object.side"});
    if (out.outOfReach > 0 && !out.isUnreachable)
        object.notes.push_back("it is felt where a hand is near");
    else if (!object.hasShape && !hidden.empty())
        append(object.notes, hidden);
    else if (!told.empty())
        append(object.faults, told);
    else if (!tie.empty())
        append(object.faults, tie);
    else if (object.hasShape && !out.isUnreachable && isFeltByContact(object, scene))
        judgeUntouched(object, scene);
    else
        object.faults.push_back(!object.hasShape ? "it isn't felt: the messages say why"
                                : out.isUnreachable
                                    ? "it isn't felt: it is out of the array's reach"
                                    : "it isn't felt: none of its points is");
}

void judgePressure(CheckedObject& object, const CheckedScene& scene)
{
    const double cap_Pa = scene.statistics.maxPressure_Pa;
    const double ears_dB = scene.statistics.exposure.limit_dB;
    const std::string cap =
        cap_Pa > 0.0 && ears_dB > 0.0
            ? fmt::format("the cap of {:.4g} Pa or {:.4g} dB at ears", cap_Pa, ears_dB)
        : ears_dB > 0.0 ? fmt::format("the ear limit of {:.4g} dB", ears_dB)
                        : fmt::format("the cap of {:.4g} Pa", cap_Pa);
    const bool isPascal = object.property.pressureUnit == osgMidair::HapticProperty::PASCAL;
    if (scene.statistics.stop == "silenced")
        object.faults.push_back("the array is silent: the messages say why");
    else if (isPascal && object.meanShare < kWeakShare)
        object.faults.push_back(
            scene.statistics.capFactor < 1.0
                ? fmt::format(
                      "{} holds it at {:.0f} % of its pressure", cap, 100.0 * object.meanShare)
                : fmt::format("the array reaches {:.0f} % of its pressure in the mean",
                              100.0 * object.meanShare));
    else if (!isPascal && !object.hasOwnPressures && object.property.pressure > kLargeRelative)
        object.notes.push_back(
            fmt::format("its pressure of {:g} is relative to that of other objects; in Pa it needs "
                        "a unit: 500 Pa in a tag or an option, PressureUnit PASCAL in a node",
                        object.property.pressure));
    else if (!isPascal && scene.statistics.capFactor < 1.0)
        object.notes.push_back(cap + " makes it quieter");
}

using osgMidair::HapticField;
using osgMidair::HapticScene;

constexpr double kFrameTime_s = 1.0 / 60.0;
constexpr int kMostMoreFrames = 200; ///< that large meshes may take to be read

/// Plays the frames of one file.
class Rehearsal
{
public:
    Rehearsal(LoadedScene& loaded, const CheckOptions& options) :
        _loaded(loaded),
        _options(options),
        _stamp(new osg::FrameStamp)
    {
        _visitor.setFrameStamp(_stamp);
        _scenes.resize(loaded.scenes().size());
    }

    int play()
    {
        int frame = 0;
        const auto start = Clock::now();
        for (;
             frame < _options.frames || (isReading() && frame < _options.frames + kMostMoreFrames);
             ++frame)
        {
            update(frame, frame);
            if (hasHands())
                std::this_thread::sleep_until(
                    start + std::chrono::duration<double>((frame + 1) * kFrameTime_s));
            gather();
        }
        update(frame, frame - 1); // takes what was told of the last field
        return frame;
    }

    /// Frames in which each object was felt and touched, by path.
    struct Frames
    {
        std::map<std::string, int> felt;
        std::map<std::string, int> touched;
    };
    const Frames& framesOf(std::size_t scene) const { return _scenes[scene]; }

private:
    using Clock = std::chrono::steady_clock;

    void update(int number, int timeFrame)
    {
        const auto frame = static_cast<unsigned int>(number + 1);
        _stamp->setFrameNumber(frame);
        _stamp->setSimulationTime(timeFrame * kFrameTime_s);
        _stamp->setReferenceTime(timeFrame * kFrameTime_s);
        _visitor.reset();
        _visitor.setTraversalNumber(frame);
        _loaded.root().accept(_visitor);
        for (const LoadedScene::Scene& scene : _loaded.scenes())
        {
            if (!LoadedScene::hiddenBy(*scene.node).empty()) continue;
            const std::uint64_t before = scene.node->getStatistics().snapshots;
            scene.node->dirtyTags(); // so that it doesn't rest: time doesn't pass as for a viewer
            scene.node->update(_stamp, LoadedScene::worldAbove(*scene.node));
            const bool isNew = scene.node->getStatistics().snapshots > before;
            if (isNew) waitFor(*scene.node);
        }
    }

    /// Waits until the field of the last frame is there, or there is none to wait for.
    void waitFor(const HapticScene& scene) const
    {
        const auto end = Clock::now() + std::chrono::duration<double>(_options.wait_s);
        while (Clock::now() < end)
        {
            const osgMidair::HapticStatistics s = scene.getStatistics();
            if (s.processed >= s.snapshots) return;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

    /// Contacts follow hands by the clock, not by frames, so that these have to last as long.
    bool hasHands() const
    {
        return std::any_of(_loaded.scenes().begin(),
                           _loaded.scenes().end(),
                           [](const LoadedScene::Scene& scene)
                           { return isRecording(scene.node->getGrantedSettings().hands); });
    }

    bool isReading() const
    {
        return std::any_of(_loaded.scenes().begin(),
                           _loaded.scenes().end(),
                           [](const LoadedScene::Scene& scene)
                           { return scene.node->getStatistics().objectsBeingRead > 0; });
    }

    void gather()
    {
        for (std::size_t i = 0; i < _scenes.size(); ++i)
        {
            const HapticScene& scene = *_loaded.scenes()[i].node;
            std::map<std::string, bool> here;
            if (const auto field = scene.getField())
                for (const HapticField::ControlPoint& point : field->getPoints())
                    if (point.achieved_Pa > 0.0 && point.object < field->getObjects().size())
                        here[field->getObjects()[point.object].path] = true;
            for (const auto& [path, any] : here)
                ++_scenes[i].felt[path];
            here.clear();
            for (const osgMidair::Touch& touch : scene.getTouches())
                here[touch.path] = true;
            for (const auto& [path, any] : here)
                ++_scenes[i].touched[path];
        }
    }

    LoadedScene& _loaded;
    const CheckOptions& _options;
    osg::ref_ptr<osg::FrameStamp> _stamp;
    osgUtil::UpdateVisitor _visitor;
    std::vector<Frames> _scenes;
};

/// Adds the parts of one object that \a field has under its path.
void measure(const HapticField& field, CheckedObject& object)
{
    osg::BoundingBoxd box;
    object.lowest_Pa = std::numeric_limits<double>::infinity();
    const auto& objects = field.getObjects();
    for (const HapticField::Object& part : objects)
    {
        if (part.path != object.path) continue;
        object.leftOut.outOfWorkspace += part.outOfWorkspace;
        object.leftOut.overBudget += part.overBudget;
        object.leftOut.crowded += part.crowded;
        object.leftOut.unpainted += part.unpainted;
        object.leftOut.invalid += part.invalid;
        object.leftOut.outOfReach += part.outOfReach;
        object.leftOut.isUnreachable = object.leftOut.isUnreachable || part.isUnreachable;
    }
    const osg::Matrixd toArray = field.getWorldToArray();
    double shares = 0.0;
    for (const HapticField::ControlPoint& point : field.getPoints())
    {
        if (point.object >= objects.size() || objects[point.object].path != object.path) continue;
        box.expandBy(point.position * toArray);
        ++object.points;
        const double share = point.wanted_Pa > 0.0 ? point.achieved_Pa / point.wanted_Pa : 1.0;
        shares += share;
        object.lowestShare = std::min(object.lowestShare, share);
        object.mean_Pa += point.achieved_Pa;
        object.wanted_Pa = std::max(object.wanted_Pa, point.wanted_Pa);
        object.lowest_Pa = std::min(object.lowest_Pa, point.achieved_Pa);
        object.highest_Pa = std::max(object.highest_Pa, point.achieved_Pa);
    }
    if (object.points == 0) object.lowest_Pa = 0.0;
    if (object.points == 0) return;
    if (object.highest_Pa <= 0.0) shares = object.lowestShare = 0.0; // nothing is wanted any more
    object.mean_Pa /= object.points;
    object.meanShare = shares / object.points;
    object.centre_m = box.center();
    object.size_m = box._max - box._min;
}

void describeArray(const HapticField& field, CheckedScene& checked)
{
    const auto array = field.getArray();
    if (!array || array->transducers.empty()) return;
    osg::BoundingBoxd box;
    for (const osgMidair::Transducer& transducer : array->transducers)
        box.expandBy(transducer.position);
    checked.transducers = static_cast<int>(array->transducers.size());
    checked.arraySize_m = box._max - box._min;
    checked.reach_m = field.getReach();
}

int at(const std::map<std::string, int>& counts, const std::string& path)
{
    const auto found = counts.find(path);
    return found == counts.end() ? 0 : found->second;
}

CheckedScene checked(const LoadedScene::Scene& scene,
                     const Rehearsal::Frames& frames,
                     int played,
                     const LoadedScene& loaded)
{
    CheckedScene result;
    result.name = scene.node->getName();
    result.asked = scene.asked;
    result.hiddenBy = LoadedScene::hiddenBy(*scene.node);
    result.granted = scene.node->getGrantedSettings();
    result.statistics = scene.node->getStatistics();
    for (const osgMidair::HapticMessage& message : result.statistics.told)
    {
        result.messages.push_back(loaded.located(message));
        result.isInside = result.isInside || message.code == "scene.inside";
    }
    const auto field = scene.node->getField();
    if (field) describeArray(*field, result);
    std::vector<osgMidair::FoundObject> found = scene.node->getFoundObjects();
    if (result.isInside) found.clear();
    std::sort(found.begin(),
              found.end(),
              [](const osgMidair::FoundObject& a, const osgMidair::FoundObject& b)
              { return a.path < b.path; });
    for (const osgMidair::FoundObject& one : found)
    {
        // Places of one node have one path, and are told together.
        if (!result.objects.empty() && result.objects.back().path == one.path) continue;
        CheckedObject& object = result.objects.emplace_back();
        object.path = one.path;
        osg::ref_ptr<osg::Node> node;
        if (one.node.lock(node)) object.name = node->getName();
        const auto* given = dynamic_cast<const osgMidair::HapticPoints*>(node.get());
        object.hasOwnPressures = given && !given->getPressures().empty();
        object.property = one.property;
        object.hasShape = one.hasShape;
        object.feltFrames = at(frames.felt, one.path);
        object.touchFrames = at(frames.touched, one.path);
        if (field) measure(*field, object);
        judge(object, result, played);
    }
    return result;
}

} // namespace

std::string pressureText(const CheckedObject& object)
{
    const osgMidair::HapticProperty& property = object.property;
    if (!property.whySilenced.empty()) return "what isn't understood";
    if (object.hasOwnPressures) return "a pressure for each point";
    return property.pressureUnit == osgMidair::HapticProperty::PASCAL
               ? fmt::format("{:g} Pa", property.pressure)
               : fmt::format("{:g} (relative)", property.pressure);
}

std::string whyNothing(const CheckedScene& scene)
{
    if (!scene.asked.enabled) return "the scene is not enabled";
    if (!scene.hiddenBy.empty()) return "the scene is hidden by " + scene.hiddenBy;
    return scene.messages.empty() ? "nothing in it is marked as haptic" : "the messages say why";
}

void judge(CheckedObject& object, const CheckedScene& scene, int frames)
{
    if (!object.property.enabled)
    {
        object.notes.push_back("it is not enabled");
        return;
    }
    const osgMidair::HapticField::Object& out = object.leftOut;
    const std::vector<std::string> large =
        toldOf(object, scene, {"object.large", "object.units", "object.small"});
    // Hands that come and go, and animation, make an object felt in some frames only.
    if (object.points == 0 && object.feltFrames == 0)
        judgeUnfelt(object, scene);
    else if (object.feltFrames > 0 && object.feltFrames < frames)
        object.notes.push_back(
            fmt::format("it is felt in {} of {} frames", object.feltFrames, frames));
    // Of what is simply too large or too small, that is the one cause.
    if (object.points > 0) append(object.faults, large);
    if (out.outOfWorkspace > 0 && large.empty())
        object.faults.push_back(points(out.outOfWorkspace, "they are out of the workspace"));
    if (out.overBudget > 0 && large.empty())
        object.faults.push_back(points(out.overBudget, "there are more than maxPoints"));
    if (out.invalid > 0) object.faults.push_back(points(out.invalid, "they are not finite"));
    if (out.crowded > 0) object.notes.push_back(points(out.crowded, "others are too near"));
    if (out.unpainted > 0) object.notes.push_back(points(out.unpainted, "intensity 0"));
    if (out.outOfReach > 0) object.notes.push_back(points(out.outOfReach, "no hand is near"));
    if (object.points > 0) judgePressure(object, scene);
}

int CheckResult::exitCode() const
{
    bool isFine = std::none_of(reading.begin(), reading.end(), isBad);
    for (const CheckedScene& scene : scenes)
    {
        isFine = isFine && std::none_of(scene.messages.begin(), scene.messages.end(), isBad) &&
                 std::all_of(scene.objects.begin(),
                             scene.objects.end(),
                             [](const CheckedObject& object) { return object.faults.empty(); });
    }
    // Another scene plays what is inside it.
    const auto isFelt = [](const CheckedScene& scene)
    { return scene.isInside || !scene.objects.empty(); };
    const bool isAnyFelt =
        !scenes.empty() && std::all_of(scenes.begin(), scenes.end(), isFelt) &&
        std::any_of(scenes.begin(),
                    scenes.end(),
                    [](const CheckedScene& scene) { return !scene.objects.empty(); });
    return isFine && isAnyFelt ? 0 : 1;
}

CheckResult checkScene(const CheckOptions& options)
{
    LoadedScene loaded(options);
    Rehearsal rehearsal(loaded, options);
    CheckResult result;
    result.file = options.file;
    result.frames = rehearsal.play();
    result.wrapped = loaded.wrapped();
    for (std::size_t i = 0; i < loaded.scenes().size(); ++i)
        result.scenes.push_back(
            checked(loaded.scenes()[i], rehearsal.framesOf(i), result.frames, loaded));
    result.reading = loaded.notices(result.scenes);
    return result;
}

} // namespace midair::samples
