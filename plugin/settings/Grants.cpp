#include "plugin/settings/Grants.h"

#include "device/DeviceUri.h"
#include "device/opening/MultiDevice.h"
#include "engine-bridge/hands/opening/HandOpening.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/UserEnvironment.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace osgMidair
{

namespace
{

namespace fs = std::filesystem;

using midair::base::MessageCode;

constexpr std::size_t kMostGrantBytes = 64 << 10;

std::string environment(const char* name)
{
    return midair::base::userVariable(name).value_or("");
}

std::string grantsFile()
{
    std::string named = environment("OSG_MIDAIR_GRANTS");
    if (!named.empty()) return named;
    const std::string config = environment("XDG_CONFIG_HOME");
    if (!config.empty()) return config + "/osgMidair/grants";
    const std::string home = environment("HOME");
    return home.empty() ? "" : home + "/.config/osgMidair/grants";
}

/// Returns why \a file can't be trusted, because somebody other than the user may have written it;
/// empty: it can.
std::string distrust(const std::string& file)
{
    struct stat about = {};
    if (::stat(file.c_str(), &about) != 0) return {}; // the reader reports the reason
    struct stat link = {};
    struct stat folder = {};
    const std::string parent = fs::absolute(file).parent_path().string();
    if (::lstat(file.c_str(), &link) != 0 || ::stat(parent.c_str(), &folder) != 0)
        return "can't be looked at";
    for (const struct stat* one : {&about, &link, &folder})
        if (one->st_uid != ::geteuid() && one->st_uid != 0)
            return one == &folder ? "is in another user's folder, should be in one of yours"
                                  : "belongs to another user, should belong to you";
    if (((about.st_mode | folder.st_mode) & (S_IWGRP | S_IWOTH)) != 0)
        return "is writable by others, or its folder is: remove that with chmod go-w";
    return {};
}

bool isName(const std::string& text)
{
    return !text.empty() &&
           std::all_of(text.begin(),
                       text.end(),
                       [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
}

/// True if \a value of the setting \a name is what a file asked for.
bool isWish(const HapticSettings& settings, const std::string& name, const std::string& value)
{
    const auto wish = settings.wishes.asked.find(name);
    return wish != settings.wishes.asked.end() && wish->second == value;
}

/// Replaces \a name by the path of that regular file in the scene's folder or below it. Returns the
/// reason if there is none; empty: success.
std::string findBesideScene(const HapticWishes& wishes, std::string& name)
{
    if (fs::path(name).is_absolute())
        return "a scene file may not name absolute paths, only files beside it";
    std::error_code error;
    fs::path folder;
    if (wishes.folder) folder = fs::canonical(wishes.folder->empty() ? "." : *wishes.folder, error);
    if (error || !wishes.folder) return "the scene's own folder is unknown";
    const fs::path file = fs::canonical(folder / name, error); // resolves links
    if (error) return "there is no such file beside the scene";
    const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
    if (end != folder.end() || rest == file.end()) return "it lies outside the scene's folder";
    if (!fs::is_regular_file(file, error))
        return "it is a device, a pipe or a folder, should be a regular file";
    name = file.string();
    return {};
}

bool isHarmless(const std::vector<std::string>& list)
{
    return std::all_of(list.begin(),
                       list.end(),
                       [](const std::string& one)
                       {
                           const std::string scheme = midair::device::DeviceUri(one).scheme();
                           return scheme == "sim" || scheme == "null";
                       });
}

/// Returns true if a device accesses files, which not even a trusted scene may do.
bool touchesFiles(const std::vector<std::string>& list)
{
    return std::any_of(list.begin(),
                       list.end(),
                       [](const std::string& one)
                       {
                           const std::string scheme = midair::device::DeviceUri(one).scheme();
                           return scheme == "record" || scheme == "play";
                       });
}

/// Returns true if hands or a head come from a program or a network that not even a trusted scene
/// may name: a loader and a helper run code, and a listening address is open to others.
bool reachesFurther(const std::string& hands)
{
    const auto has = [&hands](const char* key) { return hands.find(key) != std::string::npos; };
    return has("loader=") || has("helper=") || has("address=");
}

/// Returns \a value of a grant, with the name of an array or of a recording of hands resolved
/// beside the file of grants.
std::string beside(const std::string& folder, const std::string& value)
{
    std::optional<midair::bridge::RecordedUri> recorded = midair::bridge::RecordedUri::parse(value);
    if (!recorded) return nameBeside(folder, value);
    recorded->file = nameBeside(folder, recorded->file);
    return recorded->text();
}

} // namespace

std::string nameBeside(const std::string& folder, const std::string& name)
{
    if (name.empty() || fs::path(name).is_absolute()) return name;
    const fs::path beside = fs::path(folder) / name;
    std::error_code ignored;
    return fs::is_regular_file(beside, ignored) ? beside.string() : name;
}

void lookBeside(const std::string& folder, HapticSettings& settings)
{
    settings.array = nameBeside(folder, settings.array);
    settings.temperatureSource = nameBeside(folder, settings.temperatureSource);
    for (std::string* source : {&settings.hands, &settings.heads})
        if (auto recorded = midair::bridge::RecordedUri::parse(*source))
        {
            recorded->file = nameBeside(folder, recorded->file);
            *source = recorded->text();
        }
}

Grants::Grants(Names names, bool trustsScenes) :
    _names(std::move(names)),
    _trustsScenes(trustsScenes)
{
}

Grants::Names Grants::parse(const std::string& text)
{
    Names names;
    std::size_t begin = 0;
    for (int number = 1; begin < text.size(); ++number)
    {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        std::string line = text.substr(begin, end - begin);
        begin = end + 1;
        line = midair::base::trimmed(line.substr(0, line.find('#')));
        if (line.empty()) continue;
        const std::size_t equals = line.find('=');
        const std::string name = midair::base::trimmed(line.substr(0, equals));
        const std::string value = equals == std::string::npos
                                      ? std::string()
                                      : midair::base::trimmed(line.substr(equals + 1));
        if (!isName(name) || value.empty())
            throw std::runtime_error(
                fmt::format("line {}: \"{}\" should read NAME = VALUE, for instance desk = "
                            "usb:?max-amplitude=0.3&hold=1s",
                            number,
                            printable(line)));
        if (!names.emplace(name, value).second)
            throw std::runtime_error(
                fmt::format("line {}: the name \"{}\" is there twice", number, name));
    }
    return names;
}

bool Grants::isHarmlessDevice(const std::string& device)
{
    try
    {
        return isHarmless(midair::device::splitDeviceList(device));
    }
    catch (const std::runtime_error&) // not a valid URI
    {
        return false;
    }
}

Grants Grants::ofUser(std::vector<midair::base::Message>& messages)
{
    const std::string trust = environment("OSG_MIDAIR_TRUST");
    if (trust == "scene")
        messages.push_back({MessageCode::GRANTS_TRUST,
                            "OSG_MIDAIR_TRUST=scene: scene files may open any device and hands"});
    else if (!trust.empty())
        messages.push_back({MessageCode::GRANTS_FILE,
                            "OSG_MIDAIR_TRUST is \"" + printable(trust) +
                                "\", should be scene or nothing; scene files are not trusted"});
    Names names;
    const std::string file = grantsFile();
    std::error_code error;
    if (!file.empty() && (fs::exists(file, error) || !environment("OSG_MIDAIR_GRANTS").empty()))
    {
        std::string why = distrust(file);
        try
        {
            if (why.empty()) names = parse(midair::base::readRegularFile(file, kMostGrantBytes));
            for (auto& [name, value] : names)
                value = beside(fs::path(file).parent_path().string(), value);
        }
        catch (const std::runtime_error& wrong)
        {
            why = wrong.what();
        }
        if (!why.empty())
            messages.push_back({MessageCode::GRANTS_FILE,
                                "grants \"" + file + "\": " + why + "; nothing of it is granted"});
    }
    return Grants(std::move(names), trust == "scene");
}

const std::string* Grants::find(const std::string& name) const
{
    const auto found = _names.find(name);
    return found == _names.end() ? nullptr : &found->second;
}

HapticSettings Grants::apply(HapticSettings settings,
                             const std::string& scene,
                             std::vector<midair::base::Message>& messages) const
{
    const Refuse refuse =
        [&](MessageCode code, const char* what, const std::string& value, const std::string& why)
    {
        messages.push_back(
            {code, scene + " asks for " + what + " \"" + printable(value) + "\": " + why});
    };
    applyDevice(settings, refuse);
    applyArray(settings, refuse);
    applyHands(settings, refuse);
    applyHeads(settings, refuse);
    applyThermometer(settings, refuse);
    return settings;
}

// A reading is a number within a range, so a file beside the scene does no harm. Error messages
// about other files could disclose their content.
void Grants::applyThermometer(HapticSettings& settings, const Refuse& refuse) const
{
    const std::string asked = settings.temperatureSource;
    if (asked.empty()) return;
    if (const std::string* granted = find(asked))
    {
        settings.temperatureSource = *granted;
        return;
    }
    if (!isWish(settings, "temperatureSource", asked)) return;
    const std::string why = findBesideScene(settings.wishes, settings.temperatureSource);
    if (why.empty()) return;
    settings.temperatureSource.clear();
    refuse(MessageCode::GRANTS_REFUSED,
           "the thermometer",
           asked,
           why +
               "; the temperature setting applies. To grant it: "
               "OSG_MIDAIR_TEMPERATURE_SOURCE, -O temperatureSource=.., or a name for it "
               "in " +
               grantsFile());
}

void Grants::applyDevice(HapticSettings& settings, const Refuse& refuse) const
{
    const bool wish = isWish(settings, "device", settings.device);
    if (const std::string* granted = find(settings.device))
        settings.device = *granted;
    else if (wish)
    {
        const std::string asked = settings.device;
        try
        {
            const std::vector<std::string> list = midair::device::splitDeviceList(asked);
            if (isHarmless(list) || (_trustsScenes && !touchesFiles(list))) return;
        }
        catch (const std::runtime_error&)
        {
            // Not a valid URI: never granted.
        }
        settings.device = "sim:";
        refuse(MessageCode::GRANTS_REFUSED,
               "the device",
               asked,
               "scene files may open only sim: and null:, so sim: is used. To grant it: "
               "OSG_MIDAIR_DEVICE, -O device=.., a --device file, or a name for it in " +
                   grantsFile());
    }
}

void Grants::applyArray(HapticSettings& settings, const Refuse& refuse) const
{
    const std::string asked = settings.array;
    const bool wish = isWish(settings, "array", asked);
    if (asked == "octagon" || asked == "board") return;
    const std::vector<std::string> known = midair::haptics::TransducerArray::names();
    if (std::find(known.begin(), known.end(), asked) != known.end()) return;
    if (const std::string* granted = find(asked))
    {
        settings.array = *granted;
        return;
    }
    const std::string why = wish ? findBesideScene(settings.wishes, settings.array) : "";
    if (why.empty()) return;
    settings.array.clear();
    refuse(MessageCode::ARRAY_REFUSED,
           "the array",
           asked,
           why +
               "; nothing is played. To grant it: OSG_MIDAIR_ARRAY, -O array=.., or a "
               "name for it in " +
               grantsFile());
}

void Grants::applyHands(HapticSettings& settings, const Refuse& refuse) const
{
    const std::string asked = settings.hands;
    const bool wish = isWish(settings, "hands", asked);
    // The mouse belongs to the user at the viewer, and opens nothing.
    if (asked.empty() || asked == "none" || asked == "mouse" || asked == "mouse:") return;
    if (const std::string* granted = find(asked))
    {
        settings.hands = *granted;
        return;
    }
    if (!wish) return;
    std::string why = "scene files may open only a recording beside them";
    if (std::optional<midair::bridge::RecordedUri> recorded =
            midair::bridge::RecordedUri::parse(asked))
    {
        why = findBesideScene(settings.wishes, recorded->file);
        if (why.empty())
        {
            settings.hands = recorded->text();
            return;
        }
    }
    else if (_trustsScenes && !reachesFurther(asked))
        return;
    settings.hands.clear();
    refuse(MessageCode::GRANTS_REFUSED,
           "the hands",
           asked,
           why +
               ", so there are none. To grant them: OSG_MIDAIR_HANDS, -O hands=.., or a "
               "name for them in " +
               grantsFile());
}

// The ear limit holds at the user's head: a file could move it away with any source.
void Grants::applyHeads(HapticSettings& settings, const Refuse& refuse) const
{
    const std::string asked = settings.heads;
    const bool wish = isWish(settings, "heads", asked);
    if (asked.empty() || asked == "none") return;
    if (const std::string* granted = find(asked))
    {
        settings.heads = *granted;
        return;
    }
    if (!wish || (_trustsScenes && !reachesFurther(asked))) return;
    settings.heads.clear();
    refuse(MessageCode::GRANTS_REFUSED,
           "the head",
           asked,
           "a scene file may not set the head, because the ear limit holds there, so there is "
           "none. To "
           "grant it:  OSG_MIDAIR_HEADS, -O heads=.., or a name for it in " +
               grantsFile());
}

} // namespace osgMidair
