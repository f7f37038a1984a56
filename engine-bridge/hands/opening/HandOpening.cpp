#include "engine-bridge/hands/opening/HandOpening.h"

#include "engine-bridge/PoseAndStretch.h"
#include "engine-bridge/extending/NamedFactories.h"
#include "engine-bridge/hands/helper/HelperHandSource.h"
#include "engine-bridge/hands/helper/HelperProcess.h"
#include "engine-bridge/hands/openxr/OpenXrHandSource.h"
#include "engine-bridge/hands/osc/OscReceiver.h"
#include "haptics/base/ThrownBy.h"
#include "haptics/base/text/Quantity.h"

#include <algorithm>
#include <chrono>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

const std::string kScheme = "recorded:";
const std::string kLoop = "?loop";

using base::InputError;
using device::DeviceUri;

NamedFactories<HandSourceMaker>& registry()
{
    // Never destroyed, because threads of the application may outlive static objects.
    static auto* const all = new NamedFactories<HandSourceMaker>("hand source");
    return *all;
}

/// Returns the part of \a uri before the colon; empty if there is none.
std::string schemeOf(const std::string& uri)
{
    const std::size_t colon = uri.find(':');
    return colon == std::string::npos ? "" : uri.substr(0, colon);
}

/// The helper opens the same \a uri without a helper, and sends those hands, in the scene's world.
std::shared_ptr<HandSource> openHelper(const DeviceUri& uri, const std::string& given)
{
    const std::string file = given.empty() ? programBeside("midair-hands") : given;
    if (file.empty())
        throw uri.error(
            "the helper midair-hands is neither beside this program nor where the kit's "
            "programs are; helper=FILE names it");
    std::string own;
    std::size_t begin = uri.text().find('?') + 1;
    while (begin < uri.text().size())
    {
        const std::size_t end = std::min(uri.text().find('&', begin), uri.text().size());
        const std::string one = uri.text().substr(begin, end - begin);
        begin = end + 1;
        if (one.rfind("process=", 0) == 0 || one.rfind("helper=", 0) == 0) continue;
        own += (own.empty() ? "?" : "&") + one;
    }
    HelperOptions options;
    options.command = {
        file, "relay", "openxr:" + own, "--socket", std::to_string(HelperProcess::kSocket)};
    return std::make_shared<HelperHandSource>(options);
}

std::shared_ptr<HandSource> openOpenXr(const std::string& text)
{
    DeviceUri uri(text, "hand source");
    const OpenXrOptions options = takeOpenXrOptions(uri);
    const Eigen::Isometry3d placement = takePlacement(uri, OpenXrHandSource::upright());
    const std::string process = uri.takeText("process", "own");
    const std::string helper = uri.takeText("helper", "");
    if (process != "own" && process != "helper")
        throw uri.error("process=" + process + " should be own or helper");
    if (!helper.empty() && process != "helper")
        throw uri.error("helper=" + helper + " takes process=helper");
    uri.rejectUnknown();
    if (process == "helper") return openHelper(uri, helper);
    return std::make_shared<OpenXrHandSource>(options, placement);
}

std::shared_ptr<HandSource> openOsc(const std::string& text)
{
    DeviceUri uri(text, "hand source");
    const OscOptions options = takeOscOptions(uri);
    const Eigen::Isometry3d placement = takePlacement(uri, Eigen::Isometry3d::Identity());
    uri.rejectUnknown();
    try
    {
        return std::make_shared<OscHandSource>(options, placement);
    }
    catch (const InputError& wrong)
    {
        throw uri.error(wrong.what());
    }
}

} // namespace

Eigen::Isometry3d takePlacement(DeviceUri& uri, const Eigen::Isometry3d& otherwise)
{
    constexpr double kTolerance = 0.02; // like a scene's calibration
    const std::string matrix = uri.takeText("matrix", "");
    if (matrix.empty()) return otherwise;
    std::istringstream in(matrix);
    std::vector<double> numbers;
    for (std::string word; in >> word;)
        if (!base::parseQuantity(word, "", numbers.emplace_back())) numbers.resize(17);
    PoseAndStretch parts;
    // Read column by column, the row-major numbers are the transpose, which maps column vectors.
    if (numbers.size() != 16 || !decompose(Eigen::Map<Eigen::Matrix4d>(numbers.data()), parts) ||
        !parts.stretch.isIdentity(kTolerance))
        throw uri.error("matrix=" + matrix +
                        " should be 16 numbers of a rigid matrix, row by row, translation last");
    return parts.pose;
}

OpenXrOptions takeOpenXrOptions(DeviceUri& uri)
{
    uri.rejectPath();
    OpenXrOptions options;
    options.loader = uri.takeText("loader", options.loader);
    const std::string space = uri.takeText("space", "");
    if (!space.empty() && space != "stage" && space != "local")
        throw uri.error("space=" + space + " should be stage or local");
    if (!space.empty()) options.space = space == "stage" ? OpenXrSpace::STAGE : OpenXrSpace::LOCAL;
    return options;
}

bool OpeningHands::frameAt(double time_s, HandFrame& frame)
{
    frame.hands.clear();
    const bool isMade =
        _opening.valid() && _opening.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    const std::string thrown = base::thrownBy(
        [&]
        {
            if (isMade) _source = _opening.get();
        });
    if (!thrown.empty()) _messages.push_back(thrown);
    return _source && _source->frameAt(time_s, frame);
}

std::optional<RecordedUri> RecordedUri::parse(const std::string& uri)
{
    if (uri.compare(0, kScheme.size(), kScheme) != 0) return std::nullopt;
    RecordedUri recorded;
    recorded.file = uri.substr(kScheme.size());
    const std::size_t size = recorded.file.size();
    // A file name may end in "?loop".
    recorded.loops =
        size > kLoop.size() && recorded.file.compare(size - kLoop.size(), kLoop.size(), kLoop) == 0;
    if (recorded.loops) recorded.file.resize(size - kLoop.size());
    return recorded;
}

std::string RecordedUri::text() const
{
    return kScheme + file + (loops ? kLoop : "");
}

bool registerHands(const std::string& name, HandSourceMaker make, std::string& error)
{
    return registry().add(
        name, std::move(make), {"none", "mouse", "openxr", "osc", "recorded"}, error);
}

bool isOwnHands(const std::string& uri)
{
    return !!registry().find(schemeOf(uri));
}

std::vector<std::string> ownHandNames()
{
    return registry().names();
}

std::string unknownHands(const std::string& uri, const std::vector<std::string>& more)
{
    const std::string scheme = schemeOf(uri);
    if (uri.empty() || uri == "none" || scheme == "openxr" || scheme == "osc" ||
        scheme == "recorded" || isOwnHands(uri) ||
        std::find(more.begin(), more.end(), scheme + ":") != more.end())
        return {};
    std::vector<std::string> known = {"recorded:FILE", "recorded:FILE?loop"};
    known.insert(known.end(), more.begin(), more.end());
    known.insert(known.end(), {"openxr:", "osc:"});
    for (const std::string& name : ownHandNames())
        known.push_back(name + ":");
    const std::string last = known.back();
    known.pop_back();
    return fmt::format(
        "hand source \"{}\" is not known; {} and {} are", uri, fmt::join(known, ", "), last);
}

std::shared_ptr<HandSource> openHands(const std::string& uri, const std::vector<std::string>& more)
{
    if (uri.empty() || uri == "none") return nullptr;
    if (const auto recorded = RecordedUri::parse(uri))
        return std::make_shared<RecordedHandSource>(recorded->file, recorded->loops);
    if (schemeOf(uri) == "openxr") return openOpenXr(uri);
    if (schemeOf(uri) == "osc") return openOsc(uri);
    if (const HandSourceMaker make = registry().find(schemeOf(uri)))
        return makeNamed(make, uri, "hand source \"" + uri + "\"");
    throw InputError(unknownHands(uri, more));
}

} // namespace midair::bridge
