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

/// Answers requests in a thread of its own: the newest request wins, the newest answer is kept.
/// Both have a `frame`.
template<typename Request, typename Answer>
class LatestWorker
{
public:
    /// \a work turns a request into an answer, in the worker's thread; \a pause_s lies at least
    /// between two begins.
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

    /// The newest answer not taken yet, or null.
    std::unique_ptr<Answer> take()
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        return std::move(_answer);
    }

    /// Waits for an answer to \a frame or later; what is there after \a timeout_s, or null.
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
