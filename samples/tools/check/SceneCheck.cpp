// Plays a scene frame by frame and judges the results.
#include "samples/tools/check/SceneCheck.h"

#include "haptics/base/text/Words.h"
#include "haptics/probe/Feeling.h"
#include "samples/shared/SettingOptions.h"
#include "samples/tools/check/LoadedScene.h"
#include "samples/tools/check/Remedy.h"
#include "samples/tools/check/SensationCheck.h"

#include <osgMidair/FileFormats>
#include <osgMidair/HapticPoints>

#include <osg/BoundingBox>
#include <osg/FrameStamp>
#include <osgDB/FileNameUtils>
#include <osgDB/Registry>
#include <osgUtil/UpdateVisitor>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <map>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using osgMidair::HapticMessage;

/// An object in Pa that reaches less than this share of its target counts as too weak.
constexpr double kWeakShare = 0.9;
/// Codes of messages on what plays, not on how it was asked for.
constexpr std::array<const char*, 5> kEffects = {
    {"object.", "property.", "points.", "field.", "exposure."}};

bool isOver(const HapticMessage& message)
{
    return message.until_s > 0.0;
}

// How strong a field feels is judged for each object.
bool isBad(const CheckedMessage& one)
{
    return one.message.severity != HapticMessage::NOTICE && !isOver(one.message) &&
           one.message.code != "field.faint";
}

std::string points(unsigned int count, const char* why)
{
    return fmt::format("{} point{} left out: {}", count, count == 1 ? " is" : "s are", why);
}

/// Returns the texts of an object's messages without its path: those with one of \a codes, or all
/// warnings and faults if \a codes is empty.
std::vector<std::string> toldOf(const CheckedObject& object,
                                const CheckedScene& scene,
                                const std::vector<std::string>& codes)
{
    const std::string path = object.path + ": ";
    std::vector<std::string> texts;
    for (const CheckedMessage& one : scene.messages)
    {
        const std::string& text = one.message.text;
        if (isOver(one.message)) continue;
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

/// Adds the reason why an object with render "contact" never played.
void judgeUntouched(CheckedObject& object, const CheckedScene& scene)
{
    if (isRecording(scene.granted.hands))
        object.faults.push_back("no recorded hand touches it");
    else
        object.warnings.push_back("not tested: it plays only where a hand touches it. Add a hand "
                                  "recording: -O hands=recorded:FILE");
}

/// Returns the message that silences a scene, the first in order of cause; null if there is none.
const CheckedMessage* silencing(const CheckedScene& scene)
{
    for (const char* kind :
         {"scene.", "settings.", "property.", "array.", "device.", "solver.", ""})
        for (const CheckedMessage& one : scene.messages)
            if (one.message.severity == HapticMessage::FAULT && !isOver(one.message) &&
                one.message.code.rfind(kind, 0) == 0)
                return &one;
    return nullptr;
}

/// Adds the reason why an object never played, taken from its messages if it has any.
void judgeUnfelt(CheckedObject& object, const CheckedScene& scene)
{
    const osgMidair::HapticField::Object& out = object.leftOut;
    const std::vector<std::string> hidden = toldOf(object, scene, {"object.hidden"});
    const std::vector<std::string> told = toldOf(object, scene, {});
    const std::vector<std::string> tie = toldOf(object, scene, {"object.side"});
    if (silencing(scene))
        object.faults.push_back("nothing is played");
    else if (out.outOfReach > 0 && !out.isUnreachable)
        object.warnings.push_back("not tested: it plays only near a hand");
    else if (!object.hasShape && !hidden.empty())
        append(object.notes, hidden);
    else if (!told.empty())
        append(object.faults, told);
    else if (!tie.empty())
        append(object.faults, tie);
    else if (object.hasShape && !out.isUnreachable && isFeltByContact(object, scene))
        judgeUntouched(object, scene);
    else
        object.faults.push_back(!object.hasShape ? "it can't be felt; the messages give the reason"
                                : out.isUnreachable ? "it is out of the array's reach"
                                                    : "none of its points can be felt");
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
    if (silencing(scene) || scene.statistics.stop == "silenced")
        object.faults.push_back("nothing is played");
    else if (isPascal && object.meanShare < kWeakShare)
        object.faults.push_back(
            scene.statistics.capFactor < 1.0
                ? fmt::format(
                      "{} limits it to {:.0f} % of its pressure", cap, 100.0 * object.meanShare)
                : fmt::format("the array reaches {:.0f} % of its pressure on average",
                              100.0 * object.meanShare));
    else if (!isPascal && !object.hasOwnPressures && object.property.pressure > kLargeRelative)
        object.warnings.push_back(
            fmt::format("its pressure of {0:g} has no unit, so it only compares objects: they play "
                        "as strongly as the array can. For pascals write {0:g} Pa (in a node: "
                        "PressureUnit PASCAL)",
                        object.property.pressure));
    else if (!isPascal && scene.statistics.capFactor < 1.0)
        object.notes.push_back(cap + " lowers its pressure");
}

using osgMidair::HapticField;
using osgMidair::HapticScene;

constexpr double kFrameTime_s = 1.0 / 60.0;
constexpr int kMostMoreFrames = 200; ///< extra frames for large meshes that are still being read

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
            if (isInRealTime())
                std::this_thread::sleep_until(
                    start + std::chrono::duration<double>((frame + 1) * kFrameTime_s));
            gather();
        }
        for (const LoadedScene::Scene& scene : _loaded.scenes())
            waitForReflectors(*scene.node);
        update(frame, frame - 1); // collects the messages of the last field
        return frame;
    }

    /// The field in which an object was loudest.
    struct Loudest
    {
        double pressure_Pa = 0.0;
        osg::ref_ptr<const HapticField> field;
    };
    /// Number of frames in which each object was played and touched, by path.
    struct Frames
    {
        std::map<std::string, int> felt;
        std::map<std::string, int> touched;
        std::map<std::string, Loudest> loudest;
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
            scene.node->dirtyTags(); // keeps it from resting: frames here are not in real time
            scene.node->update(_stamp, LoadedScene::worldAbove(*scene.node));
            const bool isNew = scene.node->getStatistics().snapshots > before;
            if (isNew) waitFor(*scene.node);
        }
    }

    /// Waits until \a isReady(statistics), at most \a limit_s.
    template<typename IsReady>
    static void waitUntil(const HapticScene& scene, double limit_s, const IsReady& isReady)
    {
        const auto end = Clock::now() + std::chrono::duration<double>(limit_s);
        while (Clock::now() < end && !isReady(scene.getStatistics()))
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }

    /// Waits until the field of the last frame is solved, at most wait_s.
    void waitFor(const HapticScene& scene) const
    {
        waitUntil(scene,
                  _options.wait_s,
                  [](const osgMidair::HapticStatistics& s) { return s.processed >= s.snapshots; });
    }

    /// Waits until the field at rest is rated for the accuracy of its reflectors; one that moves on
    /// its own isn't.
    void waitForReflectors(const HapticScene& scene) const
    {
        constexpr double kMost_s = 2.0;
        waitUntil(scene,
                  std::min(_options.wait_s, kMost_s),
                  [](const osgMidair::HapticStatistics& s)
                  { return s.reflectorCount == 0 || s.points == 0 || s.reflectorRms > 0.0; });
    }

    /// Contacts and sensations follow the wall clock, so frames with hands or sensations run in
    /// real time.
    bool isInRealTime() const
    {
        const auto plays = [](const osgMidair::FoundObject& object)
        { return !object.property.sensation.empty(); };
        return std::any_of(_loaded.scenes().begin(),
                           _loaded.scenes().end(),
                           [&plays](const LoadedScene::Scene& scene)
                           {
                               const auto found = scene.node->getFoundObjects();
                               return isRecording(scene.node->getGrantedSettings().hands) ||
                                      std::any_of(found.begin(), found.end(), plays);
                           });
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
            const osg::ref_ptr<const HapticField> field = scene.getField();
            for (std::size_t l = 0; field && l < field->getPoints().size(); ++l)
            {
                const HapticField::ControlPoint& point = field->getPoints()[l];
                if (!(point.achieved_Pa > 0.0) || point.object >= field->getObjects().size())
                    continue;
                const std::string& path = field->getObjects()[point.object].path;
                here[path] = true;
                Loudest& loudest = _scenes[i].loudest[path];
                if (point.achieved_Pa > loudest.pressure_Pa) loudest = {point.achieved_Pa, field};
            }
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

/// Tries what a fingertip gets at some of the points of an object.
void touch(const HapticField& field, CheckedObject& object)
{
    constexpr std::size_t kTried = 12;
    std::vector<const HapticField::ControlPoint*> points;
    for (const HapticField::ControlPoint& point : field.getPoints())
        if (point.object < field.getObjects().size() &&
            field.getObjects()[point.object].path == object.path)
            points.push_back(&point);
    for (std::size_t i = 0; i < std::min(kTried, points.size()); ++i)
    {
        const auto& point = *points[i * points.size() / std::min(kTried, points.size())];
        const double force_N = field.getFingertipForce(point.position, point.normal);
        if (force_N < object.force_N) continue;
        object.force_N = force_N;
        object.feeling = field.getFeeling(point.position, point.normal);
    }
}

/// Sums up the parts of \a field that belong to the object's path.
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
    if (object.highest_Pa <= 0.0) shares = object.lowestShare = 0.0; // only silent points are left
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

double largestExtent(osg::Node& node)
{
    const osg::BoundingBoxd box = osgMidair::boundsOf(node);
    const osg::Vec3d size = box._max - box._min;
    return box.valid() ? std::max({size.x(), size.y(), size.z()}) : 0.0;
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
    const osg::ref_ptr<const HapticField> field = scene.node->getField();
    if (field) describeArray(*field, result);
    std::vector<osgMidair::FoundObject> found = scene.node->getFoundObjects();
    if (result.isInside) found.clear();
    std::sort(found.begin(),
              found.end(),
              [](const osgMidair::FoundObject& a, const osgMidair::FoundObject& b)
              { return a.path < b.path; });
    for (const osgMidair::FoundObject& one : found)
    {
        // All instances of a node share one path and are reported once.
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
        // A sensation's pattern takes its course, so its last field says little.
        const auto loudest = frames.loudest.find(one.path);
        const bool isOfPattern = isSensation(object) && loudest != frames.loudest.end();
        const osg::ref_ptr<const HapticField> told = isOfPattern ? loudest->second.field : field;
        if (told) measure(*told, object);
        if (told) touch(*told, object);
        judge(object, result, played);
    }
    return result;
}

} // namespace

std::string pressureText(const CheckedObject& object)
{
    const osgMidair::HapticProperty& property = object.property;
    if (!property.whySilenced.empty()) return "an invalid value";
    if (object.hasOwnPressures) return "a pressure for each point";
    return property.pressureUnit == osgMidair::HapticProperty::PASCAL
               ? fmt::format("{:g} Pa", property.pressure)
               : fmt::format("{:g}, relative to the other objects", property.pressure);
}

std::string whyNothing(const CheckedScene& scene)
{
    if (!scene.asked.enabled) return "the scene is not enabled";
    if (!scene.hiddenBy.empty()) return "the scene is hidden by " + scene.hiddenBy;
    for (const CheckedMessage& one : scene.messages)
        if (!isOver(one.message)) return one.message.text;
    return "nothing in it is tagged as haptic";
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
    object.isSizeWrong = !large.empty();
    // With hands or animation, an object may play in some frames only.
    const bool isJudged = isSensation(object) && !silencing(scene) && judgeSensation(object, scene);
    if (object.points == 0 && object.feltFrames == 0 && !isJudged)
        judgeUnfelt(object, scene);
    else if (object.feltFrames > 0 && object.feltFrames < frames && !isSensation(object))
        object.notes.push_back(
            fmt::format("it is felt in {} of {} frames", object.feltFrames, frames));
    // For an object of the wrong size, the size is the only fault worth reporting.
    if (object.points > 0) append(object.faults, large);
    if (out.outOfWorkspace > 0 && large.empty())
        object.faults.push_back(points(out.outOfWorkspace, "they are out of the workspace"));
    if (out.overBudget > 0 && large.empty())
        object.faults.push_back(points(out.overBudget, "the limit maxPoints is reached"));
    if (out.invalid > 0) object.faults.push_back(points(out.invalid, "they are not finite"));
    if (out.crowded > 0) object.notes.push_back(points(out.crowded, "others are too near"));
    if (out.unpainted > 0) object.notes.push_back(points(out.unpainted, "intensity 0"));
    if (out.outOfReach > 0) object.notes.push_back(points(out.outOfReach, "no hand is near"));
    if (object.points == 0) return;
    judgePressure(object, scene);
    object.isWeak = object.feeling == haptics::strengthName(haptics::Strength::TOO_WEAK);
    if (object.faults.empty() && object.isWeak)
        object.warnings.push_back(fmt::format(
            "it is {}: {:.2g} mN on a fingertip", object.feeling, 1e3 * object.force_N));
}

Verdict CheckedObject::verdict() const
{
    if (!faults.empty()) return Verdict::PROBLEM;
    return warnings.empty() ? Verdict::OK : Verdict::WARNING;
}

const char* verdictName(Verdict verdict)
{
    constexpr const char* kNames[] = {"OK", "WARNING", "PROBLEM"};
    return kNames[static_cast<int>(verdict)];
}

namespace
{

/// Returns the number of objects with that verdict, and of all objects.
std::pair<int, int> countOf(const CheckResult& result, Verdict verdict)
{
    std::pair<int, int> count = {0, 0};
    for (const CheckedScene& scene : result.scenes)
        for (const CheckedObject& object : scene.objects)
        {
            ++count.second;
            if (object.verdict() == verdict) ++count.first;
        }
    return count;
}

/// Returns what is wrong with a scene as a whole, or an empty string. A scene inside another has no
/// fault of its own.
std::string faultOf(const CheckedScene& scene)
{
    if (scene.isInside) return {};
    if (const CheckedMessage* one = silencing(scene)) return one->message.text;
    return scene.objects.empty() ? whyNothing(scene) : "";
}

/// Returns the path and first sentence of the first object with that verdict. A wrong size is the
/// cause of what its neighbours lack.
std::string firstOf(const CheckResult& result, Verdict verdict)
{
    const CheckedObject* first = nullptr;
    for (const CheckedScene& scene : result.scenes)
        for (const CheckedObject& object : scene.objects)
            if (object.verdict() == verdict &&
                (!first || (object.isSizeWrong && !first->isSizeWrong)))
                first = &object;
    if (!first) return {};
    return first->path + ": " +
           (verdict == Verdict::PROBLEM ? first->faults : first->warnings).front();
}

/// What OSG's readers warn of, such as a camera that is missing, and single faces that are left out
/// may not matter to any object.
bool isDoubt(const CheckedMessage& one)
{
    if (one.message.severity == HapticMessage::FAULT) return false;
    return one.message.code == "osg" || (one.message.code == "reading" &&
                                         one.message.text.find("left out") != std::string::npos);
}

/// Wrong options and settings are the cause of what objects lack.
bool isCause(const CheckedMessage& one)
{
    const std::string& code = one.message.code;
    return std::none_of(kEffects.begin(),
                        kEffects.end(),
                        [&code](const char* kind) { return code.rfind(kind, 0) == 0; });
}

/// Returns the first warning or fault for which \a is returns true, of the file before those of its
/// scenes; null: there is none.
template<typename Is>
const CheckedMessage* firstBad(const CheckResult& result, Is is)
{
    for (const CheckedMessage& message : result.reading)
        if (isBad(message) && is(message)) return &message;
    for (const CheckedScene& scene : result.scenes)
        for (const CheckedMessage& message : scene.messages)
            if (isBad(message) && is(message)) return &message;
    return nullptr;
}

/// Returns true if there are objects and all of them are switched off.
bool areAllOff(const CheckResult& result)
{
    bool isAny = false;
    for (const CheckedScene& scene : result.scenes)
        for (const CheckedObject& object : scene.objects)
        {
            if (object.property.enabled) return false;
            isAny = true;
        }
    return isAny;
}

} // namespace

Verdict CheckResult::verdict() const
{
    bool isAny = false;
    bool isWrong = firstBad(*this, [](const CheckedMessage& one) { return !isDoubt(one); });
    for (const CheckedScene& scene : scenes)
    {
        isAny = isAny || !scene.objects.empty();
        isWrong = isWrong || !faultOf(scene).empty();
    }
    if (isWrong || !isAny || countOf(*this, Verdict::PROBLEM).first > 0) return Verdict::PROBLEM;
    const bool isWarned =
        firstBad(*this, isDoubt) || countOf(*this, Verdict::WARNING).first > 0 || areAllOff(*this);
    return isWarned ? Verdict::WARNING : Verdict::OK;
}

std::string CheckResult::because() const
{
    const auto isRoot = [](const CheckedMessage& one) { return !isDoubt(one) && isCause(one); };
    const auto ofObjects = [this](Verdict verdict, const char* what) -> std::string
    {
        const auto [count, all] = countOf(*this, verdict);
        if (count == 0) return {};
        if (all == 1) return firstOf(*this, verdict);
        return fmt::format("{} of {} objects {}: {}", count, all, what, firstOf(*this, verdict));
    };
    // The first cause that there is.
    for (const CheckedMessage& message : reading)
        if (isBad(message) && !isDoubt(message)) return message.message.text;
    for (const CheckedScene& scene : scenes)
        if (std::string fault = faultOf(scene); !fault.empty()) return fault;
    if (const CheckedMessage* root = firstBad(*this, isRoot)) return root->message.text;
    if (std::string why = ofObjects(Verdict::PROBLEM, "can't be felt as asked for"); !why.empty())
        return why;
    const auto isAnother = [](const CheckedMessage& one) { return !isDoubt(one); };
    if (const CheckedMessage* bad = firstBad(*this, isAnother)) return bad->message.text;
    if (std::string why = ofObjects(Verdict::WARNING, "may not be felt"); !why.empty()) return why;
    if (const CheckedMessage* doubt = firstBad(*this, isDoubt)) return doubt->message.text;
    if (areAllOff(*this)) return "nothing plays: all objects are switched off (haptic=false)";
    const int all = countOf(*this, Verdict::OK).second;
    if (scenes.empty() || all == 0) return "nothing in it is tagged as haptic";
    return all == 1 ? "it can be felt" : fmt::format("all {} objects can be felt", all);
}

namespace
{

/// Checks the file without looking for a remedy.
CheckResult checkedOnce(const CheckOptions& options)
{
    LoadedScene loaded(options);
    Rehearsal rehearsal(loaded, options);
    CheckResult result;
    result.file = options.file;
    result.options = options.options;
    result.frames = rehearsal.play();
    result.wrapped = loaded.wrapped();
    for (std::size_t i = 0; i < loaded.scenes().size(); ++i)
        result.scenes.push_back(
            checked(loaded.scenes()[i], rehearsal.framesOf(i), result.frames, loaded));
    result.width_m = largestExtent(loaded.root()) *
                     (result.scenes.empty() ? 1.0 : result.scenes.front().granted.metresPerUnit);
    result.reading = loaded.notices(result.scenes);
    const GivenOptions given = optionsIn(options.options);
    std::vector<std::string> ignored = unknownOptions(given);
    const std::string unused = modelOption(given);
    if (!unused.empty() && osgDB::getLowerCaseFileExtension(options.file) != "haptic")
        ignored.push_back("-O " + unused + " works only with FILE.haptic and is ignored here");
    for (const std::string& text : ignored)
    {
        const auto isTold = [&text](const CheckedMessage& one)
        { return one.message.text.find(text) != std::string::npos; };
        if (std::any_of(result.reading.begin(), result.reading.end(), isTold)) continue;
        CheckedMessage& told = result.reading.emplace_back();
        told.message.severity = HapticMessage::WARNING;
        told.message.code = "reading";
        told.message.text = text;
    }
    return result;
}

/// Tries the remedies. Returns the command of the first with the verdict OK, or else of the best;
/// empty: none is better.
std::string triedRemedy(const CheckResult& result, const CheckOptions& options)
{
    constexpr std::size_t kMostTried = 8;
    constexpr int kFrames = 3;
    std::string command;
    Verdict best = result.verdict();
    std::vector<CheckOptions> all = remedies(result, options);
    all.resize(std::min(all.size(), kMostTried));
    for (CheckOptions& one : all)
    {
        const bool isByHand =
            std::any_of(result.scenes.begin(),
                        result.scenes.end(),
                        [](const CheckedScene& scene) { return isRecording(scene.granted.hands); });
        if (!isByHand) one.frames = std::min(one.frames, kFrames);
        try
        {
            osgDB::Registry::instance()->setOptions(nullptr);
            const Verdict verdict = checkedOnce(one).verdict();
            if (verdict >= best) continue;
            best = verdict;
            command = commandOf(one);
        }
        catch (const std::runtime_error&) // it can't be read so
        {
            continue;
        }
        if (best == Verdict::OK) break;
    }
    return command;
}

} // namespace

CheckResult checkScene(const CheckOptions& options)
{
    CheckResult result = checkedOnce(options);
    if (result.verdict() != Verdict::OK) result.remedy = triedRemedy(result, options);
    return result;
}

} // namespace midair::samples
