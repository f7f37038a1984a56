#pragma once

#include "haptics/Certificate.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace midair::haptics
{

/// A field that a solver played, as CertificateMonitor takes it over; immutable once submitted.
struct PlayedField
{
    ControlPoints points;
    std::shared_ptr<const TransducerArray> array;
    Medium medium;
    Eigen::VectorXcf q;       ///< m, the activations as the device plays them
    std::uint64_t number = 0; ///< the caller's own, such as a frame's
};

/// How far a live solver's fields are from the best there is, found beside it: a thread of the lowest priority takes the
/// newest field now and then and certifies it. The solver's thread never waits for it: submit() exchanges a
/// pointer, without a lock.
class CertificateMonitor
{
public:
    struct Options
    {
        CertificateOptions certificate;
        double interval_s = 1.0; ///< >= 0; from one certificate's start to the next one's
    };
    struct Result
    {
        Certificate certificate;  ///< of no meaning where error is not empty
        std::uint64_t number = 0; ///< PlayedField::number
        std::string error;        ///< why a field could not be certified
    };

    /// Throws InputError for options that are not valid.
    explicit CertificateMonitor(const Options& options);
    /// Ends after the certificate under way, if any.
    ~CertificateMonitor();
    CertificateMonitor(const CertificateMonitor&) = delete;
    CertificateMonitor& operator=(const CertificateMonitor&) = delete;

    /// True if a field that is submitted now would be looked at without delay; saves a caller making one in vain.
    bool isWaiting() const;
    /// The newest field takes the place of one that was not looked at yet. Any thread.
    void submit(std::shared_ptr<const PlayedField> field);
    /// The last result, or null before the first. Any thread.
    std::shared_ptr<const Result> latest() const;

private:
    // One deep, newest wins; no lock, since a thread of the lowest priority may be halted for long while it holds one.
    template<typename T>
    class Slot
    {
    public:
        Slot() = default;
        ~Slot() { delete _value.load(); }
        Slot(const Slot&) = delete;
        Slot& operator=(const Slot&) = delete;
        void put(std::shared_ptr<T> value)
        {
            delete _value.exchange(new std::shared_ptr<T>(std::move(value)));
        }
        /// Null if there is none since the last time.
        std::shared_ptr<T> take()
        {
            const std::unique_ptr<std::shared_ptr<T>> value(_value.exchange(nullptr));
            return value ? std::move(*value) : nullptr;
        }
        bool isEmpty() const { return _value.load() == nullptr; }

    private:
        std::atomic<std::shared_ptr<T>*> _value{nullptr};
    };

    void run();
    void sleepUntil(std::chrono::steady_clock::time_point end, bool orField);
    Result certify(const PlayedField& field);

    Options _options;
    Certifier _certifier; // the thread's
    Slot<const PlayedField> _field;
    mutable Slot<const Result> _published;
    mutable std::mutex _latestMutex; // among callers of latest(); the thread never takes it
    mutable std::shared_ptr<const Result> _latest;
    std::mutex _sleepMutex; // the thread's own, for _wake
    std::condition_variable _wake;
    std::atomic<bool> _waiting{false};
    std::atomic<bool> _stop{false};
    std::thread _thread; // the last member: starts when all others are there
};

} // namespace midair::haptics
