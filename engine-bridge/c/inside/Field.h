#pragma once

#include "device/drive/DriveSignal.h"
#include "engine-bridge/c/inside/Calls.h"
#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/sequence/FieldSequence.h"
#include "haptics/solvers/SolveReport.h"

#include <Eigen/Core>

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace midair::capi
{

/// What a midair_field stands for; immutable.
struct Field
{
    midair_field_info info{};
    std::shared_ptr<const haptics::TransducerArray> array; ///< that it was solved with
    haptics::DriveResolution drive;                        ///< its levels
    haptics::Medium medium;
    haptics::FieldSequence sequence;          ///< as it is played
    std::vector<device::DriveSignal> signals; ///< one for each of its fields
    haptics::ControlPoints points;
    Eigen::VectorXd wanted_Pa;                      ///< n
    Eigen::VectorXd achieved_Pa;                    ///< n
    std::vector<midair_object> objects;             ///< that points.object counts
    Eigen::Matrix3Xd ears = Eigen::Matrix3Xd(3, 0); ///< listening places besides those around
    double earLimit_dB = 0.0;

    /// Names and values of all figures; those of the exposure are computed when first asked for.
    const std::vector<std::pair<std::string, double>>& figures() const;

    /// Fills in what follows from the rest of info and the sequence.
    void complete();

private:
    mutable std::once_flag _measured;
    mutable std::vector<std::pair<std::string, double>> _figures;
};

Handles<midair_field, const Field>& fields();

/// Puts the figure \a name of \a all into \a value; returns false if there is none.
bool findFigure(const std::vector<std::pair<std::string, double>>& all,
                const std::string& name,
                double& value);
/// Fails with \a why there is no field: with MIDAIR_FAILED if \a solver is one of the program's,
/// else with MIDAIR_REFUSED.
[[noreturn]] void failUnsolved(const std::string& solver, const std::string& why);
/// Fails for a report of no field.
void requireSolved(const haptics::SolveReport& report);
/// True: none of its fields sounds.
bool isSilence(const Field& field);
/// Returns MIDAIR_SILENT, and keeps why, for a field that is silence; else MIDAIR_OK.
midair_status soundsOrWhy(const Field& field);

/// The field that was played of \a result; null: it has none.
std::shared_ptr<Field> fieldOf(const bridge::HologramResult& result,
                               const std::vector<midair_object>& objects);

} // namespace midair::capi
