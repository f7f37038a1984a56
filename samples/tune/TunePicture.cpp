#include "samples/tune/TunePicture.h"

#include "haptics/base/Units.h"
#include "samples/views/Plot.h"

#include <Eigen/Core>

#include <cmath>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using haptics::TransducerState;
using nlohmann::json;

std::string stateName(TransducerState state)
{
    switch (state)
    {
    case TransducerState::FINE:
        return "FINE";
    case TransducerState::REVERSED:
        return "REVERSED";
    case TransducerState::DEAD:
        return "DEAD";
    case TransducerState::UNSURE:
    case TransducerState::NOT_MEASURED:
        break;
    }
    return "UNKNOWN";
}

json rowOf(const Eigen::Vector3d& v)
{
    return {v.x(), v.y(), v.z()};
}

} // namespace

std::string drawTuning(const haptics::TuningFit& fit, const std::string& path)
{
    const haptics::TransducerArray& array = fit.array;
    json positions = json::array(), normals = json::array(), states = json::array(),
         phases = json::array(), gains = json::array();
    for (int i = 0; i < array.size(); ++i)
    {
        positions.push_back(rowOf(array.positions.col(i)));
        normals.push_back(rowOf(array.normals.col(i)));
        states.push_back(stateName(fit.states[static_cast<std::size_t>(i)]));
        const double phase_deg = base::toDegrees(array.phaseOffset_rad[i]);
        phases.push_back(phase_deg - 180.0 * std::round(phase_deg / 180.0));
        gains.push_back(array.gain[i]);
    }
    const std::size_t fine = fit.of(TransducerState::FINE).size(),
                      reversed = fit.of(TransducerState::REVERSED).size();
    return drawPlot(
        path,
        {{"kind", "tuning"},
         {"title",
          fmt::format("{}: {} of {} transducers play, {} of them reversed; {} dead",
                      array.name,
                      fine + reversed,
                      array.size(),
                      reversed,
                      fit.of(TransducerState::DEAD).size())},
         {"caption",
          fmt::format(
              "phases spread {:.1f} degrees (polarity aside), gains {:.1f} %; sides are seen "
              "from where they emit to",
              base::toDegrees(fit.phaseSpread_rad),
              100.0 * fit.gainSpread)},
         {"positions_m", positions},
         {"normals", normals},
         {"states", states},
         {"phase_deg", phases},
         {"gain", gains}});
}

} // namespace midair::samples
