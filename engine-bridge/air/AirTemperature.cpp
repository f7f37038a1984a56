#include "engine-bridge/air/AirTemperature.h"

#include "haptics/base/Limits.h"
#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

constexpr std::size_t kMostShown = 32;

// Problems, each reported once until it has ended.
constexpr const char* kBad = "bad";
constexpr const char* kStale = "stale";
constexpr const char* kClosed = "closed";

bool isBlank(const std::string& line)
{
    const std::string text = base::trimmed(line);
    return text.empty() || text.front() == '#';
}

/// Reads at most kMostRead bytes from offset \a place, or from the present position of \a
/// descriptor if -1.
std::string readSome(int descriptor, off_t place)
{
    std::string text(TemperatureSource::kMostRead, '\0');
    const ssize_t count = place < 0 ? ::read(descriptor, text.data(), text.size())
                                    : ::pread(descriptor, text.data(), text.size(), place);
    text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return text;
}

std::string reason()
{
    return std::generic_category().message(errno);
}

} // namespace

std::optional<double> temperatureOf(const std::string& line, std::string& problem)
{
    double temperature_C = 0.0;
    const std::string text = base::trimmed(line);
    const bool isRead = base::parseQuantity(text, "C", temperature_C);
    // NaN counts as out of range.
    if (isRead && temperature_C >= base::kLeastTemperature_C &&
        temperature_C <= base::kMostTemperature_C)
        return temperature_C;
    problem = fmt::format("\"{}\" is not a reading, should be a number from {:g} to {:g} C",
                          base::printable(text, kMostShown),
                          base::kLeastTemperature_C,
                          base::kMostTemperature_C);
    return std::nullopt;
}

TemperatureSource::TemperatureSource(std::string file, const base::Clock& clock) :
    _file(std::move(file)),
    _clock(clock),
    _thread([this] { run(); })
{
}

TemperatureSource::~TemperatureSource()
{
    {
        const base::Lock lock(_mutex);
        _stop = true;
    }
    _wake.notifyAll();
    _thread.join();
    if (_descriptor >= 0) ::close(_descriptor);
}

TemperatureSource::News TemperatureSource::take()
{
    const base::Lock lock(_mutex);
    News news = std::move(_news);
    _news = {};
    _news.isClosed = news.isClosed;
    return news;
}

void TemperatureSource::run()
{
    base::Lock lock(_mutex);
    while (!_stop)
    {
        lock.unlock();
        look();
        lock.lock();
        const double end_s = _clock.now_s() + kLook_s;
        while (!_stop && _clock.now_s() < end_s)
            _clock.wait(_wake, lock, end_s);
    }
}

void TemperatureSource::tell(const std::string& problem, bool isClosed)
{
    const base::Lock lock(_mutex);
    _news.isClosed = isClosed;
    if (!problem.empty()) _news.problem = problem;
}

// A pipe stays open, so that writers may follow each other; a file is opened at each look, because
// it may have been replaced.
void TemperatureSource::look()
{
    if (_descriptor >= 0) return readPipe();
    struct stat about = {};
    if (::stat(_file.c_str(), &about) != 0) return tell("can't be opened: " + reason(), true);
    if (S_ISREG(about.st_mode)) return readFile();
    if (!S_ISFIFO(about.st_mode))
        return tell("is a device or a folder, should be a file or a named pipe", true);
    _descriptor = ::open(_file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (_descriptor < 0) return tell("can't be opened: " + reason(), true);
    tell("", false);
    readPipe();
}

void TemperatureSource::readPipe()
{
    // Input of more than 16 kB a look waits in the pipe.
    for (int reads = 0; reads < 4; ++reads)
    {
        const std::string text = readSome(_descriptor, -1);
        if (text.empty()) return;
        for (const char c : text)
        {
            if (c == '\n')
                readLine(std::exchange(_pending, {}));
            else if (_pending.size() < kMostLine)
                _pending.push_back(c);
        }
    }
}

// The newest reading of a file is its last complete line; text after it may be incomplete, and
// counts once it stayed unchanged for a look.
void TemperatureSource::readFile()
{
    // Non-blocking: otherwise a file replaced by a pipe would block here.
    const int file = ::open(_file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    struct stat about = {};
    if (file < 0 || ::fstat(file, &about) != 0 || !S_ISREG(about.st_mode))
    {
        if (file >= 0) ::close(file);
        return tell("can't be opened: " + reason(), true);
    }
    const off_t first = std::max<off_t>(0, about.st_size - static_cast<off_t>(kMostRead));
    std::string text = readSome(file, first);
    ::close(file);
    tell("", false);
    const std::string state = fmt::format("{} {} {} {} ",
                                          about.st_ino,
                                          about.st_size,
                                          about.st_mtim.tv_sec,
                                          about.st_mtim.tv_nsec) +
                              text;
    const bool isNew = state != _seen;
    _seen = state;
    if (isNew)
        _isTold = false;
    else if (_isTold)
        return;
    const std::size_t whole = text.rfind('\n');
    if (!isNew || whole + 1 == text.size()) // nothing of it is still being written
        _isTold = true;
    else
        text.resize(whole == std::string::npos ? 0 : whole + 1);
    // Complete lines of an unchanged file have been read before.
    if (!isNew && whole + 1 == text.size()) return;
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r'))
        text.pop_back();
    const std::size_t before = text.rfind('\n');
    readLine(text.substr(before == std::string::npos ? 0 : before + 1));
}

void TemperatureSource::readLine(const std::string& line)
{
    if (isBlank(line)) return;
    std::string problem;
    const std::optional<double> temperature_C = temperatureOf(line, problem);
    const base::Lock lock(_mutex);
    if (temperature_C)
    {
        _news.temperature_C = temperature_C;
        return;
    }
    ++_news.bad;
    _news.problem = problem;
}

void AirTemperature::setSource(const std::string& file)
{
    if (file == _name) return;
    _source = file.empty() ? nullptr : std::make_unique<TemperatureSource>(file);
    _name = file;
    _readings = 0;
    _follows = _hasBegun = false;
    for (const char* trouble : {kBad, kStale, kClosed})
        ends(trouble);
}

double AirTemperature::at(double now_s, double set_C)
{
    return _source ? follow(_source->take(), now_s, set_C) : set_C;
}

double AirTemperature::follow(const TemperatureSource::News& news, double now_s, double set_C)
{
    if (!_hasBegun) _heard_s = now_s;
    _hasBegun = true;
    listen(news, now_s);
    if (_readings == 0) return set_C;
    if (!_follows) _now_C = set_C;
    const double way_K = median() - _now_C;
    if (std::fabs(way_K) < kLeast_K || (_follows && now_s - _stepped_s < kPause_s)) return _now_C;
    _follows = true;
    _stepped_s = now_s;
    _now_C += std::clamp(way_K, -kStep_K, kStep_K);
    return _now_C;
}

void AirTemperature::listen(const TemperatureSource::News& news, double now_s)
{
    const std::string kept = _readings > 0
                                 ? fmt::format("the last good reading, {:.1f} C, is kept", _last[0])
                                 : std::string("until then the setting temperature is used");
    if (news.temperature_C)
    {
        _last = {*news.temperature_C, _last[0], _last[1]};
        _readings = std::min(_readings + 1, 3);
        _heard_s = now_s;
        ends(kStale);
        ends(kClosed);
    }
    if (news.bad > 0) tellOnce(kBad, news.problem + "; " + kept);
    if (news.bad > 0) _bad_s = now_s;
    if (now_s - _bad_s > kStale_s) ends(kBad);
    if (news.isClosed && !news.problem.empty()) tellOnce(kClosed, news.problem + "; " + kept);
    if (now_s - _heard_s > kStale_s)
        tellOnce(kStale, fmt::format("no good reading for {:g} s; {}", kStale_s, kept));
}

double AirTemperature::median() const
{
    std::array<double, 3> sorted = _last;
    if (_readings < 3) return _last[0];
    std::sort(sorted.begin(), sorted.end());
    return sorted[1];
}

void AirTemperature::tellOnce(const char* trouble, const std::string& what)
{
    const base::Topic topic{base::MessageCode::AIR_TEMPERATURE, 0, trouble};
    if (_log.begins(topic))
        _log.say(
            topic,
            {base::MessageCode::AIR_TEMPERATURE, "temperature source \"" + _name + "\": " + what});
}

void AirTemperature::ends(const char* trouble)
{
    _log.ends({base::MessageCode::AIR_TEMPERATURE, 0, trouble});
}

} // namespace midair::bridge
