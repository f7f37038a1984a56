// What of the numbers of a check is a fault.
#include "samples/tools/check/SceneCheck.h"

#include "haptics/base/text/Words.h"
#include "haptics/probe/Feeling.h"
#include "samples/shared/SettingOptions.h"
#include "samples/tools/check/LoadedScene.h"

#include <osgMidair/HapticPoints>

#include <osg/BoundingBox>
#include <osg/ComputeBoundsVisitor>
#include <osg/FrameStamp>
#include <osgDB/FileNameUtils>
#include <osgUtil/UpdateVisitor>

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <thread>
#include <utility>

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

bool isOver(const HapticMessage& message)
{
    return message.until_s > 0.0;
}

bool isBad(const CheckedMessage& one)
{
    return one.message.severity != HapticMessage::NOTICE && !isOver(one.message);
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

/// Says why an object that is felt where hands touch it is felt in no frame.
void judgeUntouched(CheckedObject& object, const CheckedScene& scene)
{
    if (isRecording(scene.granted.hands))
        object.faults.push_back("no hand of the recording touches it");
    else
        object.warnings.push_back(
            "not tried: it is felt where a hand touches it; add a hand recording: -O "
            "hands=recorded:FILE");
}

/// The first message that silences a scene, in the order in which one follows from another; null:
/// there is none.
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

/// Says why an object is felt in no frame, in the words of the messages where there are some.
void judgeUnfelt(CheckedObject& object, const CheckedScene& scene)
{
    const osgMidair::HapticField::Object& out = object.leftOut;
    const std::vector<std::string> hidden = toldOf(object, scene, {"object.hidden"});
    const std::vector<std::string> told = toldOf(object, scene, {});
    const std::vector<std::string> tie = toldOf(object, scene, {"object.side"});
    if (silencing(scene))
        object.faults.push_back("nothing is played");
    else if (out.outOfReach > 0 && !out.isUnreachable)
        object.warnings.push_back("not tried: it is felt where a hand is near");
    else if (!object.hasShape && !hidden.empty())
        append(object.notes, hidden);
    else if (!told.empty())
        append(object.faults, told);
    else if (!tie.empty())
        append(object.faults, tie);
    else if (object.hasShape && !out.isUnreachable && isFeltByContact(object, scene))
        judgeUntouched(object, scene);
    else
        object.faults.push_back(!object.hasShape    ? "it isn't felt: the messages say why"
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

/// The first of \a options that only MODEL.haptic takes; empty: there is none.
std::string placingOption(const std::string& options)
{
    for (const char* name : {"size=", "position=", "rotation="})
        if (const std::size_t found = options.find(name);
            found != std::string::npos && (found == 0 || options[found - 1] == ' '))
            return options.substr(found, options.find(' ', found) - found);
    return {};
}

haptics::PlayedAs playedAs(const CheckedObject& object, const CheckedScene& scene)
{
    if (isFeltByContact(object, scene)) return haptics::PlayedAs::CIRCLING;
    return object.property.modulationFrequency > 0.0 ? haptics::PlayedAs::VIBRATING
                                                     : haptics::PlayedAs::HELD;
}

/// Tries what a fingertip gets at some of the points of an object.
void touch(const HapticField& field, const CheckedScene& scene, CheckedObject& object)
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
        object.force_N =
            std::max(object.force_N, field.getFingertipForce(point.position, point.normal));
    }
    if (!points.empty())
        object.feeling = haptics::feelingOf(object.force_N, playedAs(object, scene));
}

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

double largestExtent(osg::Node& node)
{
    osg::ComputeBoundsVisitor bounds;
    node.accept(bounds);
    const osg::BoundingBox& box = bounds.getBoundingBox();
    return box.valid()
               ? std::max(
                     {box.xMax() - box.xMin(), box.yMax() - box.yMin(), box.zMax() - box.zMin()})
               : 0.0;
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
        if (node) object.size_units = largestExtent(*node);
        if (field) measure(*field, object);
        if (field) touch(*field, result, object);
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
    for (const CheckedMessage& one : scene.messages)
        if (!isOver(one.message)) return one.message.text;
    return "nothing in it is marked as haptic";
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
    if (object.points == 0) return;
    judgePressure(object, scene);
    if (object.faults.empty() && object.feeling == haptics::kTooWeak)
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

/// How many objects of all scenes have that verdict.
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

/// What is wrong with a scene as a whole; empty: nothing. Another scene plays what is inside it.
std::string faultOf(const CheckedScene& scene)
{
    if (scene.isInside) return {};
    if (const CheckedMessage* one = silencing(scene)) return one->message.text;
    return scene.objects.empty() ? whyNothing(scene) : "";
}

/// The first sentence of the objects with that verdict, with the object's path.
std::string firstOf(const CheckResult& result, Verdict verdict)
{
    for (const CheckedScene& scene : result.scenes)
        for (const CheckedObject& object : scene.objects)
            if (object.verdict() == verdict)
                return object.path + ": " +
                       (verdict == Verdict::PROBLEM ? object.faults : object.warnings).front();
    return {};
}

/// A warning or fault of no object in particular; null: there is none.
const CheckedMessage* firstBad(const CheckResult& result)
{
    for (const CheckedMessage& message : result.reading)
        if (isBad(message)) return &message;
    for (const CheckedScene& scene : result.scenes)
        for (const CheckedMessage& message : scene.messages)
            if (isBad(message)) return &message;
    return nullptr;
}

} // namespace

Verdict CheckResult::verdict() const
{
    bool isAny = false;
    bool isWrong = firstBad(*this) != nullptr;
    for (const CheckedScene& scene : scenes)
    {
        isAny = isAny || !scene.objects.empty();
        isWrong = isWrong || !faultOf(scene).empty();
    }
    if (isWrong || !isAny || countOf(*this, Verdict::PROBLEM).first > 0) return Verdict::PROBLEM;
    return countOf(*this, Verdict::WARNING).first > 0 ? Verdict::WARNING : Verdict::OK;
}

std::string CheckResult::because() const
{
    for (const CheckedScene& scene : scenes)
        if (std::string fault = faultOf(scene); !fault.empty()) return fault;
    for (const Verdict verdict : {Verdict::PROBLEM, Verdict::WARNING})
    {
        const auto [count, all] = countOf(*this, verdict);
        const char* what =
            verdict == Verdict::PROBLEM ? "can't be felt as asked for" : "may not be felt";
        const CheckedMessage* bad = verdict == Verdict::WARNING ? firstBad(*this) : nullptr;
        if (bad) return bad->message.text;
        if (count > 0)
            return fmt::format(
                "{} of {} objects {}: {}", count, all, what, firstOf(*this, verdict));
    }
    const int all = countOf(*this, Verdict::OK).second;
    if (scenes.empty() || all == 0) return "nothing in it is marked as haptic";
    return all == 1 ? "it can be felt" : fmt::format("all {} objects can be felt", all);
}

std::string CheckResult::remedy() const
{
    const std::string ending = ".haptic";
    const bool isPlaced = file.size() > ending.size() &&
                          file.compare(file.size() - ending.size(), ending.size(), ending) == 0;
    std::string size;
    for (const CheckedScene& scene : scenes)
        for (const CheckedObject& object : scene.objects)
        {
            if (!size.empty() || object.faults.empty()) continue;
            const std::string& fault = object.faults.front();
            const std::size_t found = fault.find("size=");
            if (found != std::string::npos)
                size = fault.substr(found, fault.find(' ', found) - found);
            // What lies elsewhere comes into the middle by a size of its own.
            else if (object.leftOut.isUnreachable && object.size_units > 0.0 && !wrapped.empty())
                size = fmt::format("size={:.3g}", object.size_units * scene.granted.metresPerUnit);
        }
    if (size.empty() && !isPlaced) size = placingOption(options);
    if (size.empty() || (isPlaced && options.find("size=") != std::string::npos)) return {};
    std::string others = options; // without a size that is another's
    if (const std::size_t old = others.find("size="); old != std::string::npos)
        others.erase(old, others.find(' ', old) - old);
    return fmt::format("midair-check {}{} -O \"{}\"",
                       file,
                       isPlaced ? "" : ending,
                       base::trimmed(base::trimmed(others) + " " + size));
}

CheckResult checkScene(const CheckOptions& options)
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
    result.reading = loaded.notices(result.scenes);
    const std::string unused = placingOption(options.options);
    if (!unused.empty() && osgDB::getLowerCaseFileExtension(options.file) != "haptic")
    {
        CheckedMessage& told = result.reading.emplace_back();
        told.message.severity = HapticMessage::WARNING;
        told.message.code = "reading";
        told.message.text =
            "-O " + unused + " is for names that end in .haptic, and is ignored here";
    }
    return result;
}

} // namespace midair::samples
