#include "engine-bridge/hands/helper/HelperHandSource.h"

#include "engine-bridge/hands/helper/HelperProcess.h"
#include "engine-bridge/hands/osc/OscHands.h"
#include "haptics/base/InputError.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::bridge
{

namespace
{

constexpr double kLongestHelperPause_s = 30.0;
/// After this lifetime a helper is restarted after the first, shortest pause.
constexpr double kLivedWell_s = 10.0;
constexpr int kHelperTurn_ms = 100;

} // namespace

HelperHandSource::HelperHandSource(const HelperOptions& options) :
    _options(options),
    _inbox(options.name),
    _stop(::eventfd(0, EFD_CLOEXEC)),
    _thread([this] { run(); })
{
}

HelperHandSource::~HelperHandSource()
{
    const std::uint64_t one = 1;
    while (::write(_stop, &one, sizeof one) < 0 && errno == EINTR)
    {
    }
    _thread.join();
    ::close(_stop);
}

// The thread that starts the helper lives as long as the source: the system kills a helper that
// requested it together with that thread (PR_SET_PDEATHSIG).
void HelperHandSource::run()
{
    double pause_s = _options.retry_s;
    for (;;)
    {
        std::string how;
        double lived_s = 0.0;
        try
        {
            HelperProcess helper(_options.command);
            _process = helper.process();
            ++_started;
            how = follow(helper, lived_s);
            if (how.empty()) return; // the source ends, and the helper with it
            how += ", and the helper " + helper.end();
        }
        catch (const base::InputError& error)
        {
            how = error.what();
        }
        _process = 0;
        if (lived_s > kLivedWell_s) pause_s = _options.retry_s;
        lose(fmt::format("{}; no hands, it is started again in {:g} s", how, pause_s));
        pollfd stop = {_stop, POLLIN, 0};
        if (::poll(&stop, 1, static_cast<int>(1e3 * pause_s)) > 0) return;
        pause_s = std::max(pause_s, std::min(2.0 * pause_s, kLongestHelperPause_s));
    }
}

// Receives the helper's data; returns why that ended, empty for the source's end.
std::string HelperHandSource::follow(HelperProcess& helper, double& lived_s)
{
    {
        const base::Lock lock(_mutex);
        _condition.clear();
    }
    const double begin_s = base::steadySeconds();
    double heard_s = begin_s;
    double sent_s = 0.0;
    std::array<pollfd, 2> both = {{{_stop, POLLIN, 0}, {helper.socket(), POLLIN, 0}}};
    for (;;)
    {
        ::poll(both.data(), both.size(), kHelperTurn_ms);
        if (both[0].revents != 0) return {};
        const double now_s = base::steadySeconds();
        lived_s = now_s - begin_s;
        if (both[1].revents != 0)
        {
            if (!receive(helper.socket())) return "the helper closed its socket";
            heard_s = now_s;
        }
        sendHorizon(helper.socket(), sent_s);
        if (now_s - heard_s > _options.patience_s)
            return fmt::format("the helper has sent nothing for {:g} s", _options.patience_s);
    }
}

// Returns false when the helper has closed its end.
bool HelperHandSource::receive(int socket)
{
    std::array<char, kMostOscBytes + 1> bytes;
    for (;;)
    {
        const ssize_t size = ::recv(socket, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_TRUNC);
        if (size < 0) return errno == EAGAIN || errno == EINTR;
        if (size == 0) return false;
        _inbox.take(bytes.data(), static_cast<std::size_t>(size), {}, base::steadySeconds());
    }
}

void HelperHandSource::sendHorizon(int socket, double& sent_s)
{
    const double horizon_s = _horizon_s;
    if (horizon_s == sent_s) return;
    OscWriter writer;
    const std::size_t size = writer.horizon(horizon_s);
    if (::send(socket, writer.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) sent_s = horizon_s;
}

void HelperHandSource::lose(const std::string& why)
{
    _inbox.say(why);
    const base::Lock lock(_mutex);
    _condition = why;
}

bool HelperHandSource::frameAt(double time_s, HandFrame& frame)
{
    frame.time_s = time_s;
    return _inbox.latest(base::steadySeconds(), frame);
}

bool HelperHandSource::setHorizon(double ahead_s)
{
    // NaN counts as 0.
    _horizon_s = ahead_s > 0.0 ? std::min(ahead_s, kFarthestOscHorizon_s) : 0.0;
    return true;
}

std::string HelperHandSource::status() const
{
    const base::Lock lock(_mutex);
    return _inbox.status() + (_condition.empty() ? "" : "; " + _condition);
}

} // namespace midair::bridge
