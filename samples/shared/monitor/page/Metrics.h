#pragma once

#include "samples/shared/monitor/page/MonitorJson.h"

#include <string>

namespace midair::samples
{

/// Returns what is known as Prometheus reads it (text exposition format 0.0.4). While a reading is
/// old there are only midair_up 0, ages and what the page counts: Prometheus then shows that the
/// rest isn't known.
std::string metricsText(const MonitorState& state);

/// Returns "meanPhaseStep_rad" as "mean_phase_step_radians"; \a factor is what its values are to be
/// multiplied with: milliseconds become seconds.
std::string metricName(const std::string& figure, double& factor);

/// Returns \a text within the quotes of a label: valid UTF-8 in one line.
std::string labelValue(const std::string& text);

} // namespace midair::samples
