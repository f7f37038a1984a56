#pragma once

#include "engine-bridge/display/Display.h"
#include "engine-bridge/display/Picture.h"
#include "haptics/array/TransducerArray.h"

#include <osgMidair/CoincidenceFigures>

#include <Eigen/Geometry>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace midair::bridge
{

/// The viewer and the display of a scene.
struct Viewing
{
    std::shared_ptr<const Display> display; ///< null: none, as with a window on a desk
    Eigen::Isometry3d head = Eigen::Isometry3d::Identity(); ///< to the world, m
    /// why the seen places are unknown, such as a lost head; empty: known
    std::string lost;
};

/// Known errors. Each is the median of its magnitude: half of all errors are smaller; none:
/// unknown.
struct CoincidenceOptions
{
    Viewing seen;
    std::shared_ptr<const haptics::TransducerArray> array; ///< null: unknown
    Eigen::Isometry3d worldToArray = Eigen::Isometry3d::Identity();
    double temperature_C = 20.0;        ///< temperature used for solving
    std::optional<double> arrayError_m; ///< of the array's position in the world
    std::optional<double> headError_m;
    std::optional<double> airError_K;
    std::optional<double> trackerError_m;
};

/// Measured error of an object's motion: the distance between where it was played and where it was
/// seen when the sound arrived.
struct MotionError
{
    bool isKnown = false;
    double median_m = 0.0;
    double most_m = 0.0; ///< 95 % are smaller
};

/// An object with its felt place.
struct SeenObject
{
    std::uint64_t id = 0; ///< HapticObject::id
    std::string path;
    Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< m, array frame
    bool isTouched = false;                          ///< it is rendered by contacts
    MotionError motion;
};

/// Estimates the coincidence error of \a object. Errors are assumed to be independent and normal: a
/// median magnitude stands for three coordinates, or one, of the same sigma. The total combines all
/// parts in each draw.
CoincidenceFigures coincidenceOf(const CoincidenceOptions& options, const SeenObject& object);

/// One line: "3.1 mm, 95 % 6.4 mm, mostly eye", or "unknown, since .." with what is known.
std::string textOf(const CoincidenceFigures& figures);

/// Errors of the picture's pose and of the eyes' positions.
struct SightErrors
{
    Eigen::Vector3d eye = Eigen::Vector3d::Zero();     ///< m, of both
    double ipd_m = 0.0;                                ///< added to the display's
    Eigen::Vector3d picture = Eigen::Vector3d::Zero(); ///< m
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();    ///< rad, around the picture's middle
};

/// Returns where two eyes see an object that a display draws at \a place for a head at \a head:
/// where their lines of sight come nearest to each other. World, m. With StereoMode::NONE both see
/// the picture drawn for the middle between them, and therefore in the picture's plane. None if
/// they don't see it.
std::optional<Eigen::Vector3d> seenPlace(const Display& display,
                                         const Eigen::Isometry3d& head,
                                         const Eigen::Vector3d& place,
                                         const SightErrors& errors = {});

/// Returns how far a focus at \a focus moves when sound is faster by the share \a faster than
/// assumed by the solver: to the place where the phases of all transducers agree best, by least
/// squares weighted with their loudness there. Array frame, m. The focus of a single board comes
/// nearer by about faster r^2 / h.
std::optional<Eigen::Vector3d>
airShift(const haptics::TransducerArray& array, const Eigen::Vector3d& focus, double faster);

} // namespace midair::bridge
