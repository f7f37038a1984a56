#pragma once

#include "haptics/base/threads/Forks.h"
#include "haptics/base/threads/Mutex.h"

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <utility>

namespace midair::base
{

/// Worker that answers requests on its own thread. It keeps only the newest request and the newest
/// answer. An answer has a member `frame`. In a forked child it answers nothing.
template<typename Request, typename Answer>
class LatestWorker
{
public:
    /// \a work makes an answer from a request, on the worker's thread. \a pause_s: shortest time
    /// between the starts of two answers.
    explicit LatestWorker(std::function<std::unique_ptr<Answer>(const Request&)> work,
                          double pause_s = 0.0) :
        _worker(std::make_unique<Worker>(std::move(work), pause_s))
    {
    }
    ~LatestWorker() { dropOrLeave(_isOurs, _worker); }
    LatestWorker(const LatestWorker&) = delete;
    LatestWorker& operator=(const LatestWorker&) = delete;

    void submit(Request request)
    {
        if (_isOurs) _worker->submit(std::move(request));
    }

    /// Returns the newest answer not taken yet, or null.
    std::unique_ptr<Answer> take() { return _isOurs ? _worker->take() : nullptr; }

    /// Waits for an answer to \a frame or later and takes it. After \a timeout_s takes any
    /// available answer, or returns null.
    std::unique_ptr<Answer> waitFor(std::uint64_t frame, double timeout_s)
    {
        return _isOurs ? _worker->waitFor(frame, timeout_s) : nullptr;
    }

private:
    /// State shared with the thread.
    class Worker
    {
    public:
        Worker(std::function<std::unique_ptr<Answer>(const Request&)> work, double pause_s) :
            _work(std::move(work)),
            _pause_s(pause_s),
            _thread([this] { run(); })
        {
        }

        ~Worker()
        {
            {
                const Lock lock(_mutex);
                _stop = true;
            }
            _changed.notifyAll();
            _thread.join();
        }
        Worker(const Worker&) = delete;
        Worker& operator=(const Worker&) = delete;

        void submit(Request request)
        {
            {
                const Lock lock(_mutex);
                _request = std::make_unique<Request>(std::move(request));
            }
            _changed.notifyAll();
        }

        std::unique_ptr<Answer> take()
        {
            const Lock lock(_mutex);
            return std::move(_answer);
        }

        std::unique_ptr<Answer> waitFor(std::uint64_t frame, double timeout_s)
        {
            Lock lock(_mutex);
            const Clock::time_point end = after(timeout_s);
            while (!(_answer && _answer->frame >= frame) && _changed.waitUntil(lock, end))
            {
            }
            return std::move(_answer);
        }

    private:
        using Clock = std::chrono::steady_clock;

        static Clock::time_point after(double time_s)
        {
            return Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(time_s));
        }

        void run()
        {
            Lock lock(_mutex);
            for (;;)
            {
                while (!_stop && !_request)
                    _changed.wait(lock);
                if (_stop) return;
                const std::unique_ptr<Request> request = std::move(_request);
                lock.unlock();
                const Clock::time_point next = after(_pause_s);
                std::unique_ptr<Answer> answer = _work(*request);
                lock.lock();
                _answer = std::move(answer);
                _changed.notifyAll();
                while (!_stop && _changed.waitUntil(lock, next))
                {
                }
            }
        }

        std::function<std::unique_ptr<Answer>(const Request&)> _work;
        double _pause_s;
        Mutex _mutex;
        Condition _changed;
        std::unique_ptr<Request> _request MIDAIR_GUARDED_BY(_mutex);
        std::unique_ptr<Answer> _answer MIDAIR_GUARDED_BY(_mutex);
        bool _stop MIDAIR_GUARDED_BY(_mutex) = false;
        std::thread _thread;
    };

    const MadeHere _isOurs;
    std::unique_ptr<Worker> _worker;
};

} // namespace midair::base
