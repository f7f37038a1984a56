#include "samples/shared/monitor/page/MonitorAccess.h"
#include "samples/shared/monitor/page/MonitorTexts.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"
#include "tests/samples/shared/monitor/Request.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>
#include <unistd.h>

using namespace midair::samples;

namespace
{

constexpr const char* kToken = "fuzz-token-0123456789";

/// Counts what is done to it.
class Counted : public MonitorSource
{
public:
    MonitorReading read() const override
    {
        MonitorReading reading;
        reading.isMuted = isMuted;
        reading.statistics.state =
            isMuted ? osgMidair::ArrayState::MUTED : osgMidair::ArrayState::PLAYING;
        return reading;
    }
    void setMuted(bool muted) override
    {
        isMuted = muted;
        ++mutes;
    }
    std::atomic<bool> isMuted{false};
    std::atomic<int> mutes{0};
};

/// Serves a page with kToken as long as the program runs.
std::unique_ptr<Monitor> served(const std::shared_ptr<Counted>& installation)
{
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("fuzz-token" + std::to_string(::getpid()));
    std::ofstream(file) << kToken;
    std::filesystem::permissions(
        file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    auto monitor =
        std::make_unique<Monitor>(MonitorOptions{":0", file.string(), {}}, "fuzz", installation);
    std::filesystem::remove(file);
    return monitor;
}

void requireAnswer(const std::string& text)
{
    static const auto installation = std::make_shared<Counted>();
    static const std::unique_ptr<Monitor> monitor = served(installation);
    const int before = installation->mutes;
    const RawClient client(monitor->port());
    require(client.isOpen(), "a port");
    client.send(text);
    const bool isWhole = text.find("\r\n\r\n") != std::string::npos;
    if (!isWhole) client.finish(); // or it would wait for the rest
    const std::string answer = client.receive();
    require(answer.empty() ? !isWhole
                           : answer.compare(0, 9, "HTTP/1.1 ") == 0 &&
                                 answer.find("\r\n\r\n") != std::string::npos,
            "whoever has asked is answered by HTTP");
    require(answer.find(kToken) == std::string::npos, "the token isn't told");
    require(installation->mutes == before || text.find(kToken) != std::string::npos,
            "nothing is done without the token");
}

void requireTexts(const std::string& text)
{
    MonitorState state;
    state.name = text;
    state.now_s = 1.0;
    state.view.isRead = true;
    state.view.read_s = 1.0;
    osgMidair::HapticStatistics& s = state.view.reading.statistics;
    s.device = text;
    s.stop = text;
    s.figures = {{"rms", 1.0}};
    osgMidair::HapticMessage& told = s.told.emplace_back();
    told.severity = osgMidair::HapticMessage::FAULT;
    told.code = told.path = told.text = text;
    state.view.reading.array = text;
    state.view.messages[text] = {osgMidair::HapticMessage::FAULT, 1, 1};
    state.view.events.push_back({0.5, text, 1});
    require(nlohmann::json::accept(statusJson(state)), "what is shown is JSON");
    for (const char c : labelValue(text))
        require(static_cast<unsigned char>(c) >= 0x20, "a label is a line of text");
    const std::string metrics = metricsText(state);
    const auto lines = std::count(metrics.begin(), metrics.end(), '\n');
    state.name = "x";
    s.device = "x";
    state.view.reading.array = "x";
    state.view.messages = {{"x", {osgMidair::HapticMessage::FAULT, 1, 1}}};
    const std::string plain = metricsText(state);
    require(lines == std::count(plain.begin(), plain.end(), '\n'), "no text makes a line");
    for (const char c : operatorName(text, "192.0.2.1"))
        require(static_cast<unsigned char>(c) >= 0x20 && c != 0x7F, "a name is a line of text");
}

} // namespace

void fuzzMonitor(const std::uint8_t* data, std::size_t size)
{
    const std::string text(reinterpret_cast<const char*>(data), size);
    try
    {
        const MonitorAddress address = MonitorAddress::parse(text);
        require(address.port >= 0 && address.port <= 65535, "a port is one");
        const MonitorAddress again = MonitorAddress::parse(address.text());
        require(again.host == address.host && again.port == address.port,
                "an address comes back as it is written");
    }
    catch (const std::runtime_error& error)
    {
        require(*error.what() != '\0', "an error says something");
    }
    const bool isTrusted = isTrustedHost(text, {"gallery"});
    require(!isTrusted || std::all_of(text.begin(),
                                      text.end(),
                                      [](char c)
                                      {
                                          return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                                                 c == '.' || c == ':' || c == '[' || c == ']';
                                      }),
            "a host that is trusted has the characters of one");
    require(isSameToken(text, kToken) == (text == kToken), "one token is the token");
    requireTexts(text);
    requireAnswer(text);
}
