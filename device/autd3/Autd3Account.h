#pragma once

#include "device/ArrayDevice.h"
#include "device/autd3/DatagramLink.h"
#include "device/drive/DriveSignal.h"
#include "haptics/base/threads/Mutex.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace midair::device::autd3
{

/// A field or a sequence of fields for all units.
struct Job
{
    std::vector<DriveSignal> signals; ///< at least one; one: a held field
    int divider = 1;                  ///< of a sequence: a field lasts divider x 25 us
    double sentAt_s = 0;              ///< steady clock, at send()

    bool isSequence() const { return signals.size() > 1; }
};

/// Shared state between the thread of an Autd3Device and others: orders to the thread, results from
/// it. Any thread may call any member.
class Autd3Account
{
public:
    /// Requests of other threads.
    struct Orders
    {
        std::shared_ptr<const Job> job; ///< newest waiting job
        bool silence = false;
        double silence_s = 0; ///< steady clock, time of the request
    };
    /// Present output.
    struct Playing
    {
        std::shared_ptr<const Job> job; ///< null: silence
        double offset_ns = 0;           ///< the units' time minus the host's
        std::vector<bool> isLost;       ///< for each unit
    };
    /// Statistics of the thread, for benchmarks and tests.
    struct Figures
    {
        double cpu_s = 0; ///< processor time
        std::uint64_t repeats = 0;
        std::uint64_t takenBack = 0;
        std::uint64_t torn = 0;
        std::uint64_t refusals = 0; ///< refused datagrams
        double lead_s = 0;
    };

    /// Results reported by the thread.
    struct Told
    {
        DeviceReport report;    ///< without pending
        double confirmed_s = 0; ///< steady clock; acknowledged by all units
        Playing playing;
        std::string refusals; ///< Refusals::text()
        Figures figures;

        void countFault(const std::string& what)
        {
            ++report.faults;
            report.message = what;
        }
        void confirm(double asked_s) { confirmed_s = std::max(confirmed_s, asked_s); }
    };

    explicit Autd3Account(int units);

    // For the device's users.

    /// Replaces a waiting job. Returns false for null, and while units are lost.
    bool order(std::shared_ptr<Job> job) MIDAIR_EXCLUDES(_mutex);
    void orderSilence() MIDAIR_EXCLUDES(_mutex);
    void close() MIDAIR_EXCLUDES(_mutex);
    DeviceReport report() const MIDAIR_EXCLUDES(_mutex);
    /// Returns \a get of the reported results.
    template<typename Get>
    auto read(const Get& get) const MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        return get(_told);
    }

    // For the device's thread.

    bool isClosing() const { return _isClosing; }
    bool isClosedWithin(double atMost_s) MIDAIR_EXCLUDES(_mutex);
    /// Orders wake \a link from now on.
    void attach(std::shared_ptr<DatagramLink> link) MIDAIR_EXCLUDES(_mutex);
    /// Reports that the units are open; \a isBack: again.
    void noteReady(const std::string& firmware, bool isBack) MIDAIR_EXCLUDES(_mutex);
    /// Reports that the units are closed, and gives up \a lost and \a dropped jobs and all orders.
    /// \a why: the reason; empty: the device is closing.
    void detach(const std::string& why, int lost, int dropped) MIDAIR_EXCLUDES(_mutex);
    /// Returns false if there are no new orders.
    bool takeOrders(Orders& orders) MIDAIR_EXCLUDES(_mutex);
    void notePlayed(const std::shared_ptr<const Job>& job, double handedOver_s, double offset_ns)
        MIDAIR_EXCLUDES(_mutex);
    /// Lets \a change modify the reported results.
    template<typename Change>
    void tell(const Change& change) MIDAIR_EXCLUDES(_mutex)
    {
        const base::Lock lock(_mutex);
        change(_told);
    }
    void noteFault(const std::string& what)
    {
        tell([&](Told& told) { told.countFault(what); });
    }
    void noteDropped(const std::shared_ptr<const Job>& job) ///< may be null
    {
        if (job != nullptr) tell([](Told& told) { ++told.report.dropped; });
    }

private:
    void wake() MIDAIR_REQUIRES(_mutex)
    {
        if (_link != nullptr) _link->wake();
    }

    std::atomic<bool> _isClosing{false}; ///< written under _mutex
    mutable base::Mutex _mutex;
    base::Condition _closed;
    /// Used by the thread without the lock; null: no open units.
    std::shared_ptr<DatagramLink> _link MIDAIR_GUARDED_BY(_mutex);
    Orders _orders MIDAIR_GUARDED_BY(_mutex);
    bool _isOrdered MIDAIR_GUARDED_BY(_mutex) = false; ///< orders that the thread has not seen
    Told _told MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::device::autd3
