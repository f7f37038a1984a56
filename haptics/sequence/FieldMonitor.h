#pragma once

#include "haptics/base/threads/StopToken.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Geometry>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace midair::haptics
{

/// What a hand is to find: the surface, edges or vertices of a mesh, where it is.
struct FeltSurface
{
    std::shared_ptr<const TriangleMesh> mesh;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array
    Sampling sampling = Sampling::SURFACE;
    double reach_m = 0.0; ///< felt is what is within this of a control point; 0: all of it
};

/// A field that a solver played, as FieldMonitor takes it over; immutable once submitted.
struct PlayedField
{
    ControlPoints points;
    std::shared_ptr<const TransducerArray> array;
    Medium medium;
    Eigen::VectorXcf q; ///< m, the activations as the device plays them, for points
    std::vector<Eigen::VectorXcf> cycle; ///< all fields that are played in turn; empty: q alone
    std::vector<FeltSurface> surfaces;   ///< empty: no surface figures
    ControlPoints others;                ///< points of the cycle's other fields
    std::uint64_t number = 0;            ///< the caller's own, such as a frame's
};

/// Measures beside a live solver how far its fields are from the best there is, and how even they
/// are over the surface. A thread of the lowest priority takes the newest field now and then,
/// certifies it and measures it. The solver's thread never waits for it: submit() exchanges a
/// pointer, without a lock.
class FieldMonitor
{
public:
    struct Options
    {
        CertificateOptions certificate;
        double interval_s = 1.0; ///< >= 0; from one field's start to the next one's
        bool certify = true;
    };
    struct Result
    {
        Certificate certificate;   ///< points == 0: none
        SurfaceStatistics surface; ///< samples == 0: none
        std::uint64_t number = 0;  ///< PlayedField::number
        std::string error;         ///< why a field could not be certified or measured
    };

    /// Throws InputError for options that are not valid.
    explicit FieldMonitor(const Options& options);
    /// Stops the work under way; takes milliseconds of one core.
    ~FieldMonitor();
    FieldMonitor(const FieldMonitor&) = delete;
    FieldMonitor& operator=(const FieldMonitor&) = delete;

    /// True if a field that is submitted now would be measured without delay, so that a caller need
    /// not make one in vain.
    bool isWaiting() const;
    /// Hands a field over; it takes the place of one that was not measured yet. Any thread.
    void submit(std::shared_ptr<const PlayedField> field);
    /// The last result, or null before the first. Any thread.
    std::shared_ptr<const Result> latest() const;

private:
    // One deep, newest wins; no lock, since a thread of the lowest priority may be halted for long
    // while it holds one.
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
        /// The newest field, or null if none was submitted since the last call.
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
    Result examine(const PlayedField& field);
    Eigen::Matrix3Xd feltSurface(const PlayedField& field);

    /// The samples of a mesh, a fifth of a wavelength apart, which are kept while the mesh is in
    /// use.
    struct Sampled
    {
        std::shared_ptr<const TriangleMesh> mesh;
        Sampling sampling = Sampling::SURFACE;
        double spacing_m = 0.0;
        Eigen::Matrix3Xd positions;
    };
    const Sampled& sample(const FeltSurface& surface, double spacing_m);

    Options _options;
    base::StopSource _stopWork;
    Certifier _certifier;          // the thread's
    std::vector<Sampled> _sampled; // likewise
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
