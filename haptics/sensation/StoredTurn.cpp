#include "haptics/sensation/StoredTurn.h"

#include "haptics/sensation/SensationFigures.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace midair::haptics
{

namespace
{

constexpr double kSameTurn = 1e-5;        // smaller errors of a frequency count alike
constexpr double kMostTurnRate_Hz = 40e3; // a field per period of the ultrasound
constexpr double kMostTurnTicks = 255.0;  // boards store the ticks per field in a byte

/// Tries numbers of fields and turns, and keeps the best.
class TurnSearch
{
public:
    TurnSearch(const TurnStore& store, double draw_Hz, double modulation_Hz) :
        _store(store),
        _draw_Hz(draw_Hz),
        _modulation_Hz(modulation_Hz)
    {
    }

    std::optional<StoredTurn> best()
    {
        const double first_Hz = _draw_Hz > 0.0 ? _draw_Hz : _modulation_Hz;
        const double least = _draw_Hz > 0.0 ? SensationFigures::kLeastPoints : _store.leastOfPeriod;
        const int most = std::min(_store.fields, kMostStored);
        for (int fields = 2; fields <= most; ++fields)
            for (int cycles = 1; cycles * least <= fields; ++cycles)
                tryOut(fields, cycles, rateNear(first_Hz * fields / cycles));
        return _best;
    }

private:
    /// Returns the rate of the device nearest to \a rate_Hz; 0: it has none.
    double rateNear(double rate_Hz) const
    {
        if (_store.clock_Hz <= 0.0) return rate_Hz <= kMostTurnRate_Hz ? rate_Hz : 0.0;
        const double ticks = std::max(1.0, std::round(_store.clock_Hz / rate_Hz));
        return ticks <= kMostTurnTicks ? _store.clock_Hz / ticks : 0.0;
    }

    void tryOut(int fields, int cycles, double rate_Hz)
    {
        if (!(rate_Hz > 0.0)) return;
        StoredTurn turn{fields, rate_Hz, 0, 0};
        double error = 0.0;
        const auto add = [&](int count, double wanted_Hz)
        { error = std::max(error, std::abs(count * rate_Hz / fields / wanted_Hz - 1.0)); };
        if (_draw_Hz > 0.0) add(turn.turns = cycles, _draw_Hz);
        if (_modulation_Hz > 0.0)
        {
            turn.periods = _draw_Hz > 0.0
                               ? static_cast<int>(std::lround(fields * _modulation_Hz / rate_Hz))
                               : cycles;
            if (turn.periods < 1 || turn.periods * _store.leastOfPeriod > fields) return;
            add(turn.periods, _modulation_Hz);
        }
        error = std::max(error, kSameTurn);
        if (error > kMostTurnError || (_best && error >= _error)) return;
        _best = turn;
        _error = error;
    }

    const TurnStore& _store;
    double _draw_Hz;
    double _modulation_Hz;
    std::optional<StoredTurn> _best;
    double _error = std::numeric_limits<double>::infinity();
};

} // namespace

SensationCarried StoredTurn::carried() const
{
    const double all_Hz = std::numeric_limits<double>::infinity();
    return {turns > 0 ? all_Hz : 0.0, periods > 0 ? all_Hz : 0.0};
}

std::optional<StoredTurn> storedTurn(const TurnStore& store, double draw_Hz, double modulation_Hz)
{
    const SensationCarried live = SensationCarried::at(store.carried_Hz);
    const bool isDrawn = draw_Hz <= live.draw_Hz;
    const bool isModulated = modulation_Hz <= live.modulation_Hz;
    if (store.fields < 2 || (isDrawn && isModulated)) return std::nullopt;
    if (auto both = TurnSearch(store, draw_Hz, modulation_Hz).best()) return both;
    if (isDrawn || isModulated || draw_Hz == 0.0 || modulation_Hz == 0.0) return std::nullopt;
    if (auto modulated = TurnSearch(store, 0.0, modulation_Hz).best()) return modulated;
    return TurnSearch(store, draw_Hz, 0.0).best();
}

} // namespace midair::haptics
