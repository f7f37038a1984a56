#pragma once

#include "engine-bridge/contact/ContactPatch.h"
#include "engine-bridge/sensations/SensationView.h"

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <vector>

namespace midair::bridge
{

/// A contact as played, for overlays and reports; array frame, metres.
struct ContactView
{
    std::uint64_t id = 0;     ///< of the contact; never reused
    ContactPatch patch;       ///< its semi-axes are those of the touched area
    double pathMajor_m = 0.0; ///< semi-axes of the foci's ellipse
    double pathMinor_m = 0.0;
    Eigen::Matrix3Xd foci = Eigen::Matrix3Xd(3, 0); ///< 3 x n; on the skin
    Eigen::VectorXd pressure_Pa;                    ///< n; peak, wanted of each
    double speed_m_s = 0.0;                         ///< of the finger along the object
    double share = 1.0; ///< 0 .. 1; factor on the pressure while it fades
};

/// A field of contacts, with the time when it was handed over.
struct TimedField
{
    double time_s = 0.0; ///< steady clock
    Eigen::VectorXcf q;  ///< m, as the device plays it
};

/// Contacts being played, and their recent fields.
struct ContactScene
{
    std::vector<ContactView> contacts;
    std::vector<SensationView> sensations;
    double whole = 0.0; ///< 0 .. 1; factor on the field of whole objects
    /// the fields of the last kRecent_s, in order
    std::vector<std::shared_ptr<const TimedField>> recent;

    static constexpr double kRecent_s = 0.05;
};

} // namespace midair::bridge
