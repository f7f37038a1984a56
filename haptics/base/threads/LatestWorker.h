#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace midair::base
{

/// Worker that answers requests on its own thread. Only the newest request and the newest answer
/// are kept. An answer has a member `frame`.
template<typename Request, typename Answer>
class LatestWorker
{
public:
    /// \a work makes an answer from a request, on the worker's thread. \a pause_s: shortest time
    /// between the starts of two of them.
    explicit LatestWorker(std::function<std::unique_ptr<Answer>(const Request&)> work,
                          double pause_s = 0.0) :
        _work(std::move(work)),
        _pause_s(pause_s),
        _thread([this] { run(); })
    {
    }

    ~LatestWorker()
    {
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            _stop = true;
        }
        _changed.notify_all();
        _thread.join();
    }
    LatestWorker(const LatestWorker&) = delete;
    LatestWorker& operator=(const LatestWorker&) = delete;

    void submit(Request request)
    {
        {
            const std::lock_guard<std::mutex> lock(_mutex);
            _request = std::make_unique<Request>(std::move(request));
        }
        _changed.notify_all();
    }

    /// Returns the newest answer that was not taken yet, or null.
    std::unique_ptr<Answer> take()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return std::move(_answer);
    }

    /// Waits for an answer to \a frame or later and takes it. After \a timeout_s it takes the
    /// answer that is there, or returns null.
    std::unique_ptr<Answer> waitFor(std::uint64_t frame, double timeout_s)
    {
        std::unique_lock<std::mutex> lock(_mutex);
        _changed.wait_for(lock,
                          std::chrono::duration<double>(timeout_s),
                          [&] { return _answer && _answer->frame >= frame; });
        return std::move(_answer);
    }

private:
    void run()
    {
        using Clock = std::chrono::steady_clock;
        std::unique_lock<std::mutex> lock(_mutex);
        for (;;)
        {
            _changed.wait(lock, [&] { return _stop || _request; });
            if (_stop) return;
            const std::unique_ptr<Request> request = std::move(_request);
            lock.unlock();
            const auto next = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                 std::chrono::duration<double>(_pause_s));
            std::unique_ptr<Answer> answer = _work(*request);
            lock.lock();
            _answer = std::move(answer);
            _changed.notify_all();
            _changed.wait_until(lock, next, [&] { return _stop; });
        }
    }

    std::function<std::unique_ptr<Answer>(const Request&)> _work;
    double _pause_s;
    std::mutex _mutex;
    std::condition_variable _changed;
    std::unique_ptr<Request> _request;
    std::unique_ptr<Answer> _answer;
    bool _stop = false;
    std::thread _thread;
};

} // namespace midair::base
