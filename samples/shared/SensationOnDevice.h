#pragma once

#include "device/ArrayDevice.h"
#include "device/DeviceUri.h"
#include "device/boards/BoardKind.h"
#include "device/opening/DeviceRegistry.h"
#include "engine-bridge/playing/StoreOf.h"
#include "haptics/sensation/SensationFigures.h"

#include <optional>
#include <string>

#include <fmt/format.h>

namespace midair::samples
{

/// Returns how the device at \a uri takes fields, without touching hardware: a board is simulated.
/// None: only the hardware knows. Throws device::DeviceError for a device that can't exist.
inline std::optional<haptics::TurnStore>
storeOf(const std::string& uri, int transducers, double fieldRate_Hz)
{
    const device::DeviceUri wanted(uri);
    std::string rehearsed = uri;
    if (wanted.scheme() != "sim" && device::isKnownScheme(wanted.scheme()))
    {
        if (!device::makeBoardCodec(wanted.scheme())) return std::nullopt;
        rehearsed = "sim:?board=" + wanted.scheme();
        for (const char* limit : {"ramp", "mean-drive"}) // with which it repeats nothing
            if (wanted.has(limit)) rehearsed += fmt::format("&{}={}", limit, wanted.value(limit));
    }
    const auto device = device::openDevice(rehearsed, {transducers, {}});
    return bridge::storeOf(device->ability(), fieldRate_Hz);
}

/// Returns what a device makes of the sensation of \a player and its \a figures: "repeats 11
/// fields by itself: 69.93 turns a second"; empty if it plays each field as authored. Restarts the
/// player.
inline std::string onDevice(haptics::SensationPlayer& player,
                            const haptics::SensationFigures& figures,
                            const haptics::TurnStore& store)
{
    const auto live = haptics::SensationCarried::at(store.carried_Hz);
    const bool isDrawn = figures.draw_Hz <= live.draw_Hz;
    const bool isModulated = figures.modulation_Hz <= live.modulation_Hz;
    if (isDrawn && isModulated) return {};
    player.restart();
    player.sampleAt(1.0);
    if (player.steady())
        if (const auto turn = haptics::storedTurn(store, figures.draw_Hz, figures.modulation_Hz))
        {
            std::string text = fmt::format("repeats {} fields by itself:", turn->fields);
            if (turn->turns > 0) text += fmt::format(" {:.4g} turns a second", turn->draw_Hz());
            if (turn->turns > 0 && turn->periods > 0) text += ",";
            if (turn->periods > 0)
                text += fmt::format(" a modulation of {:.4g} Hz", turn->modulation_Hz());
            if (turn->turns == 0 && figures.draw_Hz > 0.0) text += ", of the brush's outline";
            return text;
        }
    return fmt::format("takes {:.3g} fields a second: {}{}{}",
                       store.carried_Hz,
                       isDrawn ? "" : "the brush is an outline",
                       isDrawn || isModulated ? "" : ", ",
                       isModulated ? "" : "the modulation is left out");
}

} // namespace midair::samples
