#include "plugin/gltf/GltfTags.h"

#include "haptics/base/text/Words.h"
#include "plugin/scene/ReflectorTag.h"
#include "plugin/settings/AllSettings.h"
#include "plugin/settings/Grants.h"

#include <osg/ValueObject>

#include <algorithm>

#include <fmt/format.h>

namespace osgMidair
{

namespace
{

using midair::base::didYouMean;
using midair::base::nearestWords;

/// The tags of nodes.
const std::vector<std::string> kTags = {"haptic", "obstacle", "reflector"};

bool isTag(const std::string& name)
{
    return std::find(kTags.begin(), kTags.end(), name) != kTags.end();
}

/// True for what a reflector says of itself; "enabled" is another tag's, too.
bool isOfReflector(const std::string& name)
{
    const std::vector<std::string> names = ReflectorTag::names();
    return name != "enabled" && std::find(names.begin(), names.end(), name) != names.end();
}

/// Returns the value as text for a tag; for lists and objects false and a text that no property
/// accepts.
bool textOf(const tinygltf::Value& value, std::string& text)
{
    if (value.IsString())
        text = value.Get<std::string>();
    else if (value.IsBool())
        text = value.Get<bool>() ? "true" : "false";
    else if (value.IsInt())
        text = std::to_string(value.Get<int>());
    else if (value.IsNumber())
        text = fmt::format("{}", value.GetNumberAsDouble());
    else
        text = "neither a text nor a number";
    return value.IsString() || value.IsBool() || value.IsNumber();
}

/// Older Blender files have no booleans: 0 and 1 stand for them.
bool isNo(const std::string& text)
{
    return text == "false" || text == "0";
}

bool isYes(const std::string& text)
{
    return text == "true" || text == "1";
}

/// Names that a property's name in extras may be a misspelling of; itself if it is valid.
std::vector<std::string> meantBy(const std::string& name)
{
    const std::vector<std::string> names = surfaceProperties().names();
    if (std::find(names.begin(), names.end(), name) != names.end()) return {name};
    return nearestWords(name, names);
}

/// Quotes a value for a tag, so that nothing in it ends it.
std::string quoted(std::string text)
{
    std::replace(text.begin(), text.end(), '"', '\'');
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, '?');
    return "\"" + text + "\"";
}

bool isProperty(const std::string& name)
{
    return surfaceProperties().find(name) != nullptr;
}

/// Reports extras of untagged objects: they are ignored, which may be a mistake.
void tellUnmarked(const std::string& name, const std::string& where, GltfMessages& messages)
{
    const std::string meant = didYouMean(name, kTags);
    if (!meant.empty())
        messages.say(where + "unknown extra \"" + printable(name) + "\"" + meant);
    else if (isProperty(name))
    {
        const std::string text = where + "has the extra \"" + name +
                                 "\", which is ignored without \"haptic\": true beside it";
        if (surfaceProperties().concernsSafety(name))
            messages.sayUnfollowed(text);
        else
            messages.say(text);
    }
}

/// Adds "name=value" to a tag, "true" and the like of the tag itself in front of it.
void addTo(std::string& tag, const std::string& name, const tinygltf::Value& value)
{
    std::string text;
    if (isTag(name) && value.IsObject())
    {
        tag.insert(0, tag.empty() ? "true" : "true; ");
        for (const auto& [inner, its] : value.Get<tinygltf::Value::Object>())
            addTo(tag, isTag(inner) ? "enabled" : inner, its);
        return;
    }
    textOf(value, text);
    if (isTag(name))
    {
        const std::string said = isYes(text) ? "true" : isNo(text) ? "false" : text;
        tag.insert(0, tag.empty() ? said : said + "; ");
    }
    else
        tag += (tag.empty() ? "" : "; ") + name + "=" + quoted(text);
}

const tinygltf::Value::Object& membersOf(const tinygltf::Value& extras)
{
    static const tinygltf::Value::Object none;
    return extras.IsObject() ? extras.Get<tinygltf::Value::Object>() : none;
}

} // namespace

void addGltfTags(const tinygltf::Value& extras,
                 const std::string& where,
                 osg::Node& node,
                 GltfMessages& messages)
{
    const tinygltf::Value::Object& members = membersOf(extras);
    const bool isHaptic = members.count("haptic") > 0;
    const bool isReflector = members.count("reflector") > 0;
    std::string tag;
    std::string reflector;
    for (const auto& [name, value] : members)
    {
        if (name == "obstacle")
        {
            std::string text;
            textOf(value, text);
            node.setUserValue("obstacle", !isNo(text));
        }
        else if (name == "reflector" || (isReflector && isOfReflector(name)))
            addTo(reflector, name, value);
        else if (name == "haptic" || (isHaptic && !meantBy(name).empty()))
            addTo(tag, name, value);
        else if (!isHaptic)
            tellUnmarked(name, where + ": ", messages);
        else
            messages.say(where + ": the extra \"" + printable(name) +
                         "\" resembles no property and is ignored");
    }
    if (isHaptic) node.setUserValue("haptic", tag);
    if (isReflector) node.setUserValue("reflector", reflector);
}

// "enabled" is a setting and a property; on a scene it is the setting, as in options.
void addGltfSceneTags(const tinygltf::Scene& scene, osg::Node& root, GltfMessages& messages)
{
    tinygltf::Value::Object others;
    for (const auto& [name, value] : membersOf(scene.extras))
    {
        const bool isSetting = sceneSettings().find(name) ||
                               (!isProperty(name) && !isTag(name) && !isOfReflector(name) &&
                                !nearestWords(name, sceneSettings().names()).empty());
        std::string text;
        textOf(value, text);
        if (isSetting)
            messages.addSetting(name + "=" + quoted(text));
        else
            others.emplace(name, value);
    }
    addGltfTags(tinygltf::Value(std::move(others)),
                "scene \"" + printable(scene.name) + "\"",
                root,
                messages);
}

bool isMarked(const tinygltf::Value& extras)
{
    const tinygltf::Value::Object& members = membersOf(extras);
    return std::any_of(
        kTags.begin(), kTags.end(), [&](const std::string& tag) { return members.count(tag) > 0; });
}

bool saysHowItFeels(const tinygltf::Value& extras)
{
    const tinygltf::Value::Object& members = membersOf(extras);
    return isMarked(extras) ||
           std::any_of(members.begin(),
                       members.end(),
                       [](const auto& one)
                       { return isProperty(one.first) || !didYouMean(one.first, kTags).empty(); });
}

tinygltf::Value joinedExtras(const tinygltf::Value& node, const tinygltf::Value& mesh)
{
    tinygltf::Value::Object joined = membersOf(node);
    for (const auto& one : membersOf(mesh))
        joined.insert(one); // unless the node has it
    return tinygltf::Value(std::move(joined));
}

bool isHapticExtra(const std::string& name)
{
    return isTag(name) || (isProperty(name) && surfaceProperties().concernsSafety(name)) ||
           (sceneSettings().find(name) && sceneSettings().concernsSafety(name));
}

} // namespace osgMidair
