#pragma once

#include "device/drive/DriveSignal.h"
#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/probe/FingertipForce.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/SolveReport.h"

#include <Eigen/Core>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace midair::capi
{

/// Name of the figure Field::fingertip().
constexpr const char* kFingertipForce = "fingertipForce_N";

/// The object behind a midair_field; immutable.
struct Field
{
    midair_field_info info{};
    std::shared_ptr<const haptics::TransducerArray> array; ///< used for solving
    haptics::DriveResolution drive;                        ///< its levels
    haptics::Medium medium;
    haptics::FieldSequence sequence;          ///< as played
    std::vector<device::DriveSignal> signals; ///< one for each of its fields
    haptics::ControlPoints points;
    Eigen::VectorXd wanted_Pa;                      ///< n
    Eigen::VectorXd achieved_Pa;                    ///< n
    std::vector<midair_object> objects;             ///< indexed by points.object
    Eigen::Matrix3Xd ears = Eigen::Matrix3Xd(3, 0); ///< in addition to places around the array
    double earLimit_dB = 0.0;
    double feelThreshold_N = 0.0;
    std::optional<haptics::FingertipForce> felt; ///< as the pipeline measured it

    /// Names and values of all figures; exposure figures are computed on demand.
    const std::vector<std::pair<std::string, double>>& figures() const;
    /// Force on a fingertip at the strongest place; computed at each call.
    haptics::FingertipForce fingertip() const;

    /// Computes the remaining members from info and the sequence.
    void complete();

private:
    mutable std::once_flag _measured;
    mutable std::vector<std::pair<std::string, double>> _figures;
};

Handles<midair_field, const Field>& fields();

/// Stores the figure \a name of \a all in \a value; returns false if there is none.
bool findFigure(const std::vector<std::pair<std::string, double>>& all,
                const std::string& name,
                double& value);
/// Fails with the reason \a why: MIDAIR_FAILED if \a solver is one of the program's, else
/// MIDAIR_REFUSED.
[[noreturn]] void failUnsolved(const std::string& solver, const std::string& why);
/// Fails if the report has no field.
void requireSolved(const haptics::SolveReport& report);
/// True if none of its fields sounds.
bool isSilence(const Field& field);
/// Returns MIDAIR_SILENT and stores the reason for a silent field; else MIDAIR_OK.
midair_status soundsOrWhy(const Field& field);

/// Returns the played field of \a result; null if there is none.
std::shared_ptr<Field> fieldOf(const bridge::HologramResult& result,
                               const std::vector<midair_object>& objects);

} // namespace midair::capi
