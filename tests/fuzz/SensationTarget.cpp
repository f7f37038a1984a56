#include "haptics/base/InputError.h"
#include "haptics/sensation/SensationEvaluator.h"
#include "haptics/sensation/SensationPlayer.h"
#include "haptics/sensation/SensationReader.h"
#include "tests/fuzz/FuzzTargets.h"
#include "tests/fuzz/Require.h"

#include <algorithm>
#include <memory>
#include <string>

using namespace midair;

void fuzzSensation(const std::uint8_t* data, std::size_t size)
{
    try
    {
        const auto sensation = std::make_shared<const haptics::Sensation>(
            haptics::readSensation(std::string(reinterpret_cast<const char*>(data), size), "fuzz"));
        require(sensation->keyframes.size() <= haptics::Sensation::kMostKeyframes,
                "a pattern has not too many keyframes");
        require(std::is_sorted(sensation->keyframes.begin(),
                               sensation->keyframes.end(),
                               [](const auto& a, const auto& b) { return a.time_ms < b.time_ms; }),
                "keyframes are in order");
        const haptics::SensationEvaluator evaluator(sensation);
        haptics::SensationState state;
        haptics::SensationPlayer player(sensation);
        for (const double time_ms : {0.0, 1.0, 2.3, 50.0, 333.0, 5000.0, 1e9})
        {
            evaluator.evaluate(time_ms, player.values(), state);
            const haptics::SensationSample sample = player.sampleAt(time_ms);
            require(sample.position_mm.allFinite(), "a place is finite");
            require(sample.intensity >= 0.0 && sample.intensity <= 1.0,
                    "an intensity is within 0 .. 1");
        }
    }
    catch (const base::InputError& error)
    {
        require(*error.what() != '\0', "an error says something");
    }
}
