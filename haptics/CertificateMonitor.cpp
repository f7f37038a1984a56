#include "haptics/CertificateMonitor.h"

#include "haptics/InputError.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <utility>

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#endif

namespace midair::haptics
{

namespace
{

using Clock = std::chrono::steady_clock;

void takeLowestPriority()
{
#ifdef __linux__
    // Runs only on cores that nobody else wants; needs no rights. If it is refused, the thread runs all the same.
    const sched_param none{};
    pthread_setschedparam(pthread_self(), SCHED_IDLE, &none);
#endif
}

const CertificateMonitor::Options& checked(const CertificateMonitor::Options& options)
{
    if (options.interval_s >= 0.0 && options.interval_s <= 1e6) return options;
    char text[96];
    std::snprintf(text,
                  sizeof text,
                  "certificate monitor: interval_s is %g; it must be from 0 to 1e6",
                  options.interval_s);
    throw InputError(text);
}

} // namespace

CertificateMonitor::CertificateMonitor(const Options& options) :
    _options(checked(options)),
    _certifier(options.certificate),
    _thread([this] { run(); })
{
}

CertificateMonitor::~CertificateMonitor()
{
    _stop = true;
    _wake.notify_one();
    _thread.join();
}

bool CertificateMonitor::isWaiting() const
{
    return _waiting && _field.isEmpty();
}

void CertificateMonitor::submit(std::shared_ptr<const PlayedField> field)
{
    _field.put(std::move(field));
    _wake.notify_one();
}

std::shared_ptr<const CertificateMonitor::Result> CertificateMonitor::latest() const
{
    const std::lock_guard<std::mutex> lock(_latestMutex);
    if (auto result = _published.take()) _latest = std::move(result);
    return _latest;
}

void CertificateMonitor::run()
{
    takeLowestPriority();
    const auto interval = std::chrono::duration_cast<Clock::duration>(
        std::chrono::duration<double>(_options.interval_s));
    while (!_stop)
    {
        _waiting = true;
        sleepUntil(Clock::time_point::max(), true);
        _waiting = false;
        const Clock::time_point next = Clock::now() + interval;
        if (const auto field = _field.take())
            _published.put(std::make_shared<const Result>(certify(*field)));
        sleepUntil(next, false);
    }
}

void CertificateMonitor::sleepUntil(Clock::time_point end, bool orField)
{
    // The caller notifies without the mutex, so a call can be missed: then this looks again.
    constexpr std::chrono::milliseconds kLookAgain(50);
    std::unique_lock<std::mutex> lock(_sleepMutex);
    while (!_stop && !(orField && !_field.isEmpty()) && Clock::now() < end)
        _wake.wait_until(lock, std::min(end, Clock::now() + kLookAgain));
}

CertificateMonitor::Result CertificateMonitor::certify(const PlayedField& field)
{
    Result result;
    result.number = field.number;
    try
    {
        if (!field.array) throw InputError("certificate monitor: the field has no array");
        result.certificate = _certifier.certify(field.points, *field.array, field.medium, field.q);
    }
    catch (const std::exception& error)
    {
        result.error = error.what();
    }
    return result;
}

} // namespace midair::haptics
