#pragma once

#include "engine-bridge/pipeline/SceneSnapshot.h"
#include "engine-bridge/playing/LineRate.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/sequence/Modulator.h"
#include "haptics/sequence/TimeMultiplexer.h"

#include <Eigen/Core>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// What is to be played for one set of control points.
struct MadeFields
{
    std::vector<Eigen::VectorXcf> fields; ///< m each; several are played in turn, one is held
    /// Each point once: parts[k] are points that fields[k] is for, at its full targets. As many as fields, or fewer.
    std::vector<haptics::ControlPoints> parts;
    haptics::ModulatorOptions modulation; ///< of all of it, and how fast fields follow each other
    haptics::SolveReport report;          ///< of all fields together
};

/// The points of all \a parts, of which there is at least one.
haptics::ControlPoints allOf(const std::vector<haptics::ControlPoints>& parts);

/// Makes the fields for a set of control points: one for all of them, one for each subset in turn, or one for each instant
/// of the modulation of objects that are not all modulated alike.
///
/// The array plays one field at a time, so that all objects share one frequency: that of the modulated object of the
/// highest priority, of equal ones the first; each keeps its depth. Where all have the same depth the field itself is
/// modulated. Else a period is played in as many fields as the field rate allows, kMostSteps at most, each with the targets of its
/// instant, and subsets are not made. A modulation of everything (the options') goes before the objects' own.
class FieldMaker
{
public:
    struct Options
    {
        std::function<std::unique_ptr<haptics::HologramSolver>(bool absolute)> makeSolver;
        int subsets = 1; ///< >= 1; of the points, played in turn
        haptics::ModulatorOptions modulation;
        LineRate line; ///< to the device; what it doesn't carry is not made
    };

    FieldMaker(Options options, base::MessageLog& messages) :
        _options(std::move(options)),
        _messages(messages)
    {
    }

    /// \a set numbers the point sets of the scene: each starts warm from its own last fields. \a points.object indexes
    /// \a objects. Where the report says REFUSED there are no fields. Throws base::Stopped where a solver was stopped, and
    /// base::InputError for a modulation that the line doesn't carry. Sets of more than base::kMostPointsInTurn points
    /// together start cold, some of them.
    MadeFields make(int set,
                    const std::vector<HapticObject>& objects,
                    const haptics::ControlPoints& points,
                    bool absolute,
                    const haptics::TransducerArray& array,
                    const haptics::Medium& medium);

    static constexpr int kMostSteps = 16;

private:
    /// How the points are to be modulated.
    struct Beat
    {
        double rate_Hz = 0.0;
        Eigen::VectorXd depth; ///< n
        bool alike = true;     ///< all points by the same
    };

    Beat beatOf(const std::vector<HapticObject>& objects, const haptics::ControlPoints& points);
    std::vector<haptics::ControlPoints>
    split(const Beat& beat, const haptics::ControlPoints& points, MadeFields& made);
    haptics::TimeMultiplexer& solvers(int set, bool absolute);
    void makeRoom(const std::pair<int, bool>& key, int points);

    Options _options;
    base::MessageLog& _messages;
    std::map<std::pair<int, bool>, haptics::TimeMultiplexer> _solvers;
    std::map<std::pair<int, bool>, int> _points; ///< of all fields that these keep matrices for
    std::map<std::pair<int, bool>, std::vector<Eigen::VectorXcf>> _last; ///< what they left
};

} // namespace midair::bridge
