#include "haptics/sensation/SensationFigures.h"

#include "haptics/base/Percentile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace midair::haptics
{

double SensationFigures::pointsPerTurn(double rate_Hz) const
{
    return draw_Hz > 0.0 ? rate_Hz / draw_Hz : std::numeric_limits<double>::infinity();
}

SensationFigures measureSensation(SensationPlayer& player, double most_ms)
{
    SensationFigures figures;
    std::vector<double> speeds_m_s;
    const auto steps = static_cast<long>(most_ms / SensationPlayer::kStep_ms);
    SensationSample last;
    player.restart();
    for (long step = 0; step <= steps; ++step)
    {
        const double time_ms = static_cast<double>(step) * SensationPlayer::kStep_ms;
        const SensationSample sample = player.sampleAt(time_ms);
        figures.isLimited = figures.isLimited || sample.isLimited;
        figures.isBroken = figures.isBroken || !sample.isFinite;
        if (sample.isStopped)
        {
            figures.duration_ms = time_ms;
            break;
        }
        if (sample.intensity > 0.0)
        {
            if (std::isnan(figures.low_mm.x()))
                figures.low_mm = figures.high_mm = sample.position_mm;
            figures.low_mm = figures.low_mm.cwiseMin(sample.position_mm);
            figures.high_mm = figures.high_mm.cwiseMax(sample.position_mm);
            figures.mostIntensity = std::max(figures.mostIntensity, sample.intensity);
            figures.modulation_Hz =
                std::max(figures.modulation_Hz, std::abs(sample.brush.modulation_Hz));
            if (sample.brush.x_mm != 0.0 || sample.brush.y_mm != 0.0)
                figures.draw_Hz = std::max(figures.draw_Hz, std::abs(sample.brush.draw_Hz));
            // mm in ms are m/s
            if (last.intensity > 0.0)
                speeds_m_s.push_back((sample.position_mm - last.position_mm).norm() /
                                     SensationPlayer::kStep_ms);
        }
        last = sample;
    }
    figures.speed_m_s = base::percentile(std::move(speeds_m_s), 0.5);
    return figures;
}

} // namespace midair::haptics
