#pragma once

#include "haptics/array/TransducerArray.h"

#include <osgViewer/Viewer>

#include <Eigen/Core>

#include <chrono>
#include <functional>
#include <optional>
#include <vector>

namespace midair::bench
{

/// A field, and when it was handed to the device, on the steady clock.
struct NotedDrive
{
    double time_s = 0.0;
    std::vector<unsigned char> phases;
    std::vector<unsigned char> amplitudes;
};

/// From here on "noted:" is a device that notes what it is to play, and the solvers "foci-sleeps"
/// and "foci-works" put a focus to each point and take as long as setSolver_ms() says: asleep, or
/// at work.
void registerNoted();
void setSolver_ms(double time_ms);
/// What "noted:" was given since the last call.
std::vector<NotedDrive> takeDrives();

/// Finds where a field is loudest by adding up waves: it knows no more of the kit than where the
/// transducers are.
class FocusFinder
{
public:
    FocusFinder(const haptics::TransducerArray& array, double wavelength_m);

    /// Across the array (x and y), near \a place; nothing for silence.
    std::optional<Eigen::Vector3d> near(const NotedDrive& drive, Eigen::Vector3d place) const;

private:
    std::vector<Eigen::Index> _used; ///< some hundred of the transducers
    Eigen::Matrix3Xd _positions;
    double _wavenumber_m;
};

/// Frames 90 times a second: events and updates as osgViewer runs them, nothing drawn.
class Frames90
{
public:
    explicit Frames90(osg::Node* root);

    /// Waits for the next frame, calls \a before with the time, and runs it.
    void frame(const std::function<void(double time_s)>& before = {});
    void framesFor(double seconds, const std::function<void(double time_s)>& before = {});
    /// Runs the present frame's traversals, without waiting.
    void traverse();
    void wait();

private:
    osgViewer::Viewer _viewer;
    std::chrono::steady_clock::time_point _next = std::chrono::steady_clock::now();
};

} // namespace midair::bench
