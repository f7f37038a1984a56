#include "plugin/gltf/GltfTags.h"

#include "haptics/base/text/NearestWord.h"
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

/// The value as a tag has it; false for lists and objects, as a text that no property takes.
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

/// Blender has no yes and no in its older files: 0 and 1 stand for them.
bool isNo(const std::string& text)
{
    return text == "false" || text == "0";
}

bool isYes(const std::string& text)
{
    return text == "true" || text == "1";
}

/// What a property's name in extras may be a slip of the pen for; itself if it is one.
std::vector<std::string> meantBy(const std::string& name)
{
    const std::vector<std::string> names = surfaceProperties().names();
    if (std::find(names.begin(), names.end(), name) != names.end()) return {name};
    return nearestWords(name, names);
}

/// A value in a tag, so that nothing in it ends it.
std::string quoted(std::string text)
{
    std::replace(text.begin(), text.end(), '"', '\'');
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, '?');
    return "\"" + text + "\"";
}

/// Extras of a node that isn't marked: nothing of it is felt, which may not be what was meant.
void tellUnmarked(const std::string& name, const std::string& where, GltfMessages& messages)
{
    const std::string meant = didYouMean(name, {"haptic", "obstacle"});
    const std::vector<std::string> names = surfaceProperties().names();
    if (!meant.empty())
        messages.say(where + "unknown extra \"" + printable(name) + "\"" + meant);
    else if (std::find(names.begin(), names.end(), name) != names.end())
        messages.say(where + "has the extra \"" + name +
                     "\", and isn't felt without \"haptic\": true");
}

} // namespace

void addGltfTags(const tinygltf::Node& from, osg::Node& node, GltfMessages& messages)
{
    if (!from.extras.IsObject()) return;
    const std::string where = "node \"" + printable(from.name) + "\": ";
    const tinygltf::Value::Object& extras = from.extras.Get<tinygltf::Value::Object>();
    const bool isHaptic = extras.count("haptic") > 0;
    std::string tag;
    for (const auto& [name, value] : extras)
    {
        std::string text;
        textOf(value, text);
        if (name == "obstacle")
            node.setUserValue("obstacle", !isNo(text));
        else if (name == "haptic")
        {
            const std::string said = isYes(text) ? "true" : isNo(text) ? "false" : text;
            tag.insert(0, tag.empty() ? said : said + "; ");
        }
        else if (!isHaptic)
            tellUnmarked(name, where, messages);
        else if (meantBy(name).empty())
            messages.say(where + "the extra \"" + printable(name) +
                         "\" is like no property, and is left to others");
        else
            tag += (tag.empty() ? "" : "; ") + name + "=" + quoted(text);
    }
    if (isHaptic) node.setUserValue("haptic", tag);
}

} // namespace osgMidair
