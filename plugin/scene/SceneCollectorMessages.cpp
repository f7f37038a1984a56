// What a SceneCollector tells of marks and objects.
#include "engine-bridge/scene/GeometryReader.h"
#include "engine-bridge/scene/drawn/DrawnState.h"
#include "plugin/scene/SceneCollector.h"

#include <algorithm>

#include <fmt/format.h>

namespace osgMidair
{

using midair::base::about;
using midair::base::MessageCode;

void SceneCollector::tellMarks(const osg::Node& root)
{
    const std::string path = midair::bridge::quoted(root);
    if (_marks.state() == SceneMarks::State::UNKNOWN)
        _say(
            about(MessageCode::SCENE_INCOMPLETE,
                  path,
                  fmt::format("{} is not loaded yet and may have what is marked as haptic; nothing "
                              "is felt until a mark is found or all is loaded",
                              _marks.missing())));
    else if (_marks.state() == SceneMarks::State::NONE && _unmarked)
        _say(about(MessageCode::SCENE_UNMARKED,
                   path,
                   "nothing in it is marked as haptic, shown or hidden, so all of it is felt"));
    else if (_marks.state() == SceneMarks::State::NONE)
        _say(
            about(MessageCode::SCENE_EMPTY,
                  path,
                  "has no HapticSurface, no HapticPoints and no node with a haptic tag; nothing is "
                  "felt"));
    else if (_unmarked && !(*_unmarked == HapticProperty()))
        _say(about(MessageCode::SETTINGS_INVALID,
                   path,
                   "how an object is felt is given for a scene in which nothing is marked; here "
                   "something is, so its own properties count"));
}

void SceneCollector::tellHidden(const std::vector<SceneRoot>& roots)
{
    const auto& all = _visitor.instances();
    const bool isHidden =
        _marks.state() == SceneMarks::State::SOME && !roots.empty() &&
        std::all_of(all.begin(), all.end(), [](const HapticInstance& one) { return one.obstacle; });
    if (isHidden && !_told.isHidden)
        _say(about(MessageCode::OBJECT_HIDDEN,
                   midair::bridge::quoted(*roots.front().node),
                   "what is marked as haptic in it is hidden, disabled, unloaded or removed; "
                   "nothing is felt until it is shown"));
    _told.isHidden = isHidden;
}

void SceneCollector::sayWarnings(MessageCode code, const std::string& path)
{
    for (const std::string& warning : _warnings)
        _say(about(code, path, warning));
}

void SceneCollector::tellGeometry(Known& known)
{
    sayWarnings(MessageCode::OBJECT_GEOMETRY, known.path);
    known.isGeometryTold = known.isGeometryTold || !_warnings.empty();
}

// Objects are filled in again whenever another one has changed; a cause is told once while it
// lasts.
void SceneCollector::tellCause(Known& known, MessageCode code, const std::string& cause)
{
    if (known.cause == cause) return;
    known.cause = cause;
    _say(about(code, known.path, cause));
}

// What the states on the path to an object do to what is seen of it, when it is met first. What is
// below it is told when it is read, and a drawable is.
void SceneCollector::tellStates(const HapticInstance& instance, const std::string& path)
{
    const auto look = [&](const osg::Node& node)
    {
        if (node.asDrawable()) return;
        const std::string what = midair::bridge::notFeltOf(node);
        if (what.empty()) return;
        const std::string text = midair::bridge::quoted(node) + " " + what;
        _say(about(MessageCode::OBJECT_GEOMETRY, path, text));
    };
    _visitor.lookAlong(instance, look);
}

} // namespace osgMidair
