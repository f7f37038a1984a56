#include "samples/monitor/server/ConnectionLoop.h"

#include "samples/monitor/server/Connections.h"
#include "samples/monitor/server/PlainAnswer.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <list>
#include <mutex>
#include <stdexcept>
#include <utility>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

constexpr int kPoll_ms = 100;

double loopTime_s()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

/// Returns who called, as a number; an IPv4 address that came as IPv6 is written as IPv4.
std::string peerOf(const sockaddr_storage& address)
{
    std::array<char, INET6_ADDRSTRLEN> text{};
    if (address.ss_family == AF_INET)
        ::inet_ntop(AF_INET,
                    &reinterpret_cast<const sockaddr_in*>(&address)->sin_addr,
                    text.data(),
                    text.size());
    else
        ::inet_ntop(AF_INET6,
                    &reinterpret_cast<const sockaddr_in6*>(&address)->sin6_addr,
                    text.data(),
                    text.size());
    const std::string peer = text.data();
    const std::string mapped = "::ffff:";
    return peer.compare(0, mapped.size(), mapped) == 0 ? peer.substr(mapped.size()) : peer;
}

} // namespace

/// What the threads share: requests one way, answers the other.
class ConnectionLoop::Shared
{
public:
    Shared(OwnedFile listener, const ConnectionLimits& limits, Answer answer) :
        _listener(std::move(listener)),
        _wake(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
        _limits(limits),
        _answer(std::move(answer))
    {
        if (_wake.get() < 0) throw std::runtime_error("the operator's page has no file left");
    }

    void stop()
    {
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            _isStopped = true;
        }
        _changed.notify_all();
        wake();
    }

    /// Moves bytes until stop().
    void run()
    {
        while (!isStopped())
        {
            std::vector<pollfd> polled = {{_wake.get(), POLLIN, 0}};
            // Without a file left there is no sense in being told again and again.
            const bool isListening = loopTime_s() >= _deafUntil_s;
            polled.push_back({_listener.get(), static_cast<short>(isListening ? POLLIN : 0), 0});
            for (const Connection& each : _connections)
                polled.push_back(each.polled());
            ::poll(polled.data(), polled.size(), kPoll_ms);
            if (polled[0].revents != 0) takeAnswers();
            const double now_s = loopTime_s();
            std::size_t i = 2;
            for (Connection& each : _connections)
                step(each, polled[i++].revents, now_s);
            if ((polled[1].revents & POLLIN) != 0) accept(now_s);
            _connections.remove_if([](const Connection& each)
                                   { return each.stage() == Connection::CLOSED; });
        }
        _connections.clear();
    }

    /// Makes answers until stop().
    void work()
    {
        for (;;)
        {
            Job job;
            {
                std::unique_lock<std::mutex> lock(_mutex);
                _changed.wait(lock, [this] { return _isStopped || !_jobs.empty(); });
                if (_isStopped) return;
                job = std::move(_jobs.front());
                _jobs.pop_front();
            }
            job.text = _answer(job.text, job.peer);
            {
                const std::lock_guard<std::mutex> lock(_mutex);
                _answers.push_back(std::move(job));
            }
            wake();
        }
    }

private:
    /// A request, then its answer.
    struct Job
    {
        std::uint64_t number = 0; ///< of the connection
        std::string peer;
        std::string text;
    };

    bool isStopped()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return _isStopped;
    }

    void wake() const
    {
        const std::uint64_t one = 1;
        // It fails if it is full alone, when it wakes already.
        [[maybe_unused]] const ssize_t written = ::write(_wake.get(), &one, sizeof(one));
    }

    void step(Connection& connection, short events, double now_s)
    {
        const bool wasReading = connection.stage() == Connection::READING;
        connection.move(events, now_s, _limits);
        if (wasReading && connection.stage() == Connection::WORKING && !queue(connection))
            connection.write(plainAnswer(503, "too many ask at once"), now_s, _limits);
        if (connection.stage() != Connection::CLOSED && now_s > connection.end_s())
            connection.expire(now_s, _limits);
    }

    bool queue(const Connection& connection)
    {
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            if (_jobs.size() >= _limits.waiting) return false;
            _jobs.push_back({connection.number(), connection.peer(), connection.head()});
        }
        _changed.notify_one();
        return true;
    }

    void takeAnswers()
    {
        std::uint64_t count = 0;
        [[maybe_unused]] const ssize_t got = ::read(_wake.get(), &count, sizeof(count));
        std::vector<Job> answers;
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            answers.swap(_answers);
        }
        for (Job& each : answers)
            for (Connection& connection : _connections)
                if (connection.number() == each.number && connection.stage() == Connection::WORKING)
                    connection.write(std::move(each.text), loopTime_s(), _limits);
    }

    void accept(double now_s)
    {
        for (int i = 0; i < 16; ++i)
        {
            sockaddr_storage from{};
            socklen_t size = sizeof(from);
            OwnedFile socket(::accept4(_listener.get(),
                                       reinterpret_cast<sockaddr*>(&from),
                                       &size,
                                       SOCK_NONBLOCK | SOCK_CLOEXEC));
            if (socket.get() < 0)
            {
                const bool isWithoutFile = errno == EMFILE || errno == ENFILE || errno == ENOBUFS;
                if (isWithoutFile && !makeRoom()) _deafUntil_s = now_s + 0.2;
                return;
            }
            if (_connections.size() >= _limits.connections && !makeRoom()) continue; // hangs up
            _connections.emplace_back(
                std::move(socket), peerOf(from), ++_number, now_s + _limits.head_s);
        }
    }

    /// Hangs up on the oldest that has not asked yet, or has its answer: whoever asks slowly must
    /// not keep others out. Returns false if there is none.
    bool makeRoom()
    {
        const auto found = std::find_if(_connections.begin(),
                                        _connections.end(),
                                        [](const Connection& each)
                                        { return each.stage() != Connection::WORKING; });
        if (found == _connections.end()) return false;
        _connections.erase(found);
        return true;
    }

    // Of the thread that moves bytes, alone.
    OwnedFile _listener;
    std::list<Connection> _connections; ///< the oldest first
    std::uint64_t _number = 0;
    double _deafUntil_s = 0.0;

    OwnedFile _wake;
    const ConnectionLimits _limits;
    const Answer _answer;
    std::mutex _mutex; ///< guards what follows
    std::condition_variable _changed;
    std::deque<Job> _jobs;
    std::vector<Job> _answers;
    bool _isStopped = false;
};

ConnectionLoop::ConnectionLoop(const MonitorAddress& address,
                               const ConnectionLimits& limits,
                               Answer answer)
{
    OwnedFile listener = listenOn(address);
    _port = portOf(listener);
    _shared = std::make_shared<Shared>(std::move(listener), limits, std::move(answer));
    _threads.start("the operator's page", [shared = _shared] { shared->run(); });
    for (int i = 0; i < limits.workers; ++i)
        _threads.start("a thread of the operator's page", [shared = _shared] { shared->work(); });
}

ConnectionLoop::~ConnectionLoop()
{
    _shared->stop();
    if (!_threads.finish(2.0))
        std::fprintf(stderr, "the operator's page: an answer hangs; it is left to itself\n");
}

} // namespace midair::samples
