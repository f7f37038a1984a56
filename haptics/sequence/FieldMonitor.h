#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/base/threads/StopToken.h"
#include "haptics/points/ControlPoints.h"
#include "haptics/propagation/SurfaceStatistics.h"
#include "haptics/solvers/certificate/Certificate.h"
#include "haptics/surface/SurfaceSampler.h"
#include "haptics/surface/TriangleMesh.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace midair::haptics
{

/// Effect on a field of air 1 K warmer than it was solved for: sound is faster by 0.17 %, so waves
/// from near and far transducers no longer arrive in phase.
struct KelvinCost
{
    double rms = 0.0;   ///< relative, at the points; 0: not measured
    double level = 0.0; ///< fitted level over that in \a medium; 0: not measured
};

/// Compares |p| at those of \a points that have a target for \a q (m) in \a medium and in air 1 K
/// warmer, or colder if the medium can't be warmer. Takes as long as two matrices for the points.
/// Returns 0 without such points, and for silence. Throws base::Stopped.
KelvinCost kelvinCost(const ControlPoints& points,
                      const Eigen::VectorXcf& q,
                      const TransducerArray& array,
                      const Medium& medium,
                      int threads,
                      const base::StopToken& stop = {});

/// A touchable object: the surface, edges or vertices of a mesh, and its pose.
struct FeltSurface
{
    std::shared_ptr<const TriangleMesh> mesh;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); ///< mesh -> array
    Sampling sampling = Sampling::SURFACE;
    double reach_m = 0.0; ///< only parts within this distance of a control point count; 0: all
};

/// A played field, the input of FieldMonitor; immutable once submitted.
struct PlayedField
{
    ControlPoints points; ///< for the certificate; empty: no certificate
    std::shared_ptr<const TransducerArray> array;
    Medium medium;
    Eigen::VectorXcf q;                  ///< m activations for points, as played by the device
    std::vector<Eigen::VectorXcf> cycle; ///< all fields played in turn; empty: only q
    double fieldRate_Hz = 0.0; ///< >= 0; of the cycle's fields; 0: ringing figures without ringing
    std::vector<FeltSurface> surfaces; ///< empty: no surface figures
    ControlPoints others;              ///< points of the cycle's other fields
    bool isEvened = false;    ///< over the surfaces, which are then measured at other places
    std::uint64_t number = 0; ///< any number of the caller, such as the frame's
};

/// Measures in the background how far the fields of a live solver are from the optimum and how
/// uniform they are over the surface. A thread of the lowest priority takes the newest field from
/// time to time, certifies it and measures it. The solver's thread never waits for it: submit()
/// exchanges a pointer without a lock.
class FieldMonitor
{
public:
    struct Options
    {
        CertificateOptions certificate;
        double interval_s = 1.0; ///< >= 0; shortest time between the starts of two measurements
        bool certify = true;
    };
    struct Result
    {
        Certificate certificate;   ///< points == 0: none
        SurfaceStatistics surface; ///< samples == 0: none
        KelvinCost kelvin;         ///< of q at points; level == 0: none
        std::uint64_t number = 0;  ///< PlayedField::number
        bool isEvened = false;     ///< PlayedField::isEvened
        std::string error;         ///< reason if a field could not be certified or measured
    };

    /// Throws InputError for options that are not valid.
    explicit FieldMonitor(const Options& options);
    /// Stops the current work, which takes milliseconds of one core.
    ~FieldMonitor();
    FieldMonitor(const FieldMonitor&) = delete;
    FieldMonitor& operator=(const FieldMonitor&) = delete;

    /// Returns true if a field submitted now would be measured without delay; otherwise callers
    /// need not make one.
    bool isWaiting() const { return _waiting && _field.isEmpty(); }
    /// Submits a field, which replaces an unmeasured one. Any thread.
    void submit(std::shared_ptr<const PlayedField> field);
    /// Returns the last result, or null before the first. Any thread.
    std::shared_ptr<const Result> latest() const;

private:
    // Slot for one value; the newest wins. It has no lock, because a thread of the lowest priority
    // may be suspended for long while holding one.
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
        /// Returns the newest value, or null if none was put since the last call.
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

    /// Samples of a mesh, a fifth of a wavelength apart, kept while the mesh is in use.
    struct Sampled
    {
        std::shared_ptr<const TriangleMesh> mesh;
        Sampling sampling = Sampling::SURFACE;
        double spacing_m = 0.0;
        bool isBetween = false; // sampleBetween()
        Eigen::Matrix3Xd positions;
    };
    const Sampled& sample(const FeltSurface& surface, double spacing_m, bool isBetween);

    Options _options;
    base::StopSource _stopWork;
    Certifier _certifier;          // used only by the thread
    std::vector<Sampled> _sampled; // used only by the thread
    Slot<const PlayedField> _field;
    mutable Slot<const Result> _published;
    mutable base::Mutex _latestMutex; // for callers of latest(); the thread never locks it
    mutable std::shared_ptr<const Result> _latest MIDAIR_GUARDED_BY(_latestMutex);
    base::Mutex _sleepMutex; // used only by the thread, for _wake
    base::Condition _wake;
    std::atomic<bool> _waiting{false};
    std::atomic<bool> _stop{false};
    std::thread _thread; // last member, so that it starts after all others are constructed
};

} // namespace midair::haptics
