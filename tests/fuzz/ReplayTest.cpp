#include "tests/fuzz/FuzzTargets.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace
{

using Bytes = std::vector<std::uint8_t>;
using Target = void (*)(const std::uint8_t*, std::size_t);

std::vector<Bytes> corpus(const std::string& name)
{
    std::vector<std::filesystem::path> paths;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(MIDAIR_FUZZ_CORPUS) + "/" + name))
        paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    std::vector<Bytes> inputs;
    for (const auto& path : paths)
    {
        std::ifstream file(path, std::ios::binary);
        inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    return inputs;
}

// The corpus as it is and with what a fuzzer would try first: flipped, lost, doubled and foreign
// bytes. Repeatable.
void replay(const std::string& name, Target target)
{
    const std::vector<Bytes> inputs = corpus(name);
    ASSERT_GE(inputs.size(), 5U);
    std::mt19937 random(1);
    for (const Bytes& input : inputs)
    {
        target(input.data(), input.size());
        for (int round = 0; round < 150; ++round)
        {
            Bytes bytes = input;
            for (unsigned change = 0; change < 1 + random() % 3 && !bytes.empty(); ++change)
            {
                const auto at = static_cast<std::ptrdiff_t>(random() % bytes.size());
                const auto end = at +
                                 static_cast<std::ptrdiff_t>(
                                     random() % (bytes.size() - static_cast<std::size_t>(at))) +
                                 1;
                const Bytes piece(bytes.begin() + at, bytes.begin() + end);
                const Bytes& other = inputs[random() % inputs.size()];
                switch (random() % 4)
                {
                case 0:
                    bytes[static_cast<std::size_t>(at)] ^=
                        static_cast<std::uint8_t>(1U << (random() % 8));
                    break;
                case 1:
                    bytes.erase(bytes.begin() + at, bytes.begin() + end);
                    break;
                case 2:
                    bytes.insert(bytes.begin() + at, piece.begin(), piece.end());
                    break;
                default:
                    bytes.insert(bytes.begin() + at, other.begin(), other.end());
                }
            }
            target(bytes.data(), bytes.size());
        }
    }
}

} // namespace

TEST(Fuzz, protocol_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("protocol", fuzzProtocol);
}

TEST(Fuzz, autd3_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("autd3", fuzzAutd3);
}

TEST(Fuzz, units_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("units", fuzzUnits);
}

TEST(Fuzz, recording_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("recording", fuzzRecording);
}

TEST(Fuzz, uri_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("uri", fuzzUri);
}

TEST(Fuzz, obj_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("obj", fuzzObj);
}

TEST(Fuzz, array_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("array", fuzzArray);
}

TEST(Fuzz, points_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("points", fuzzPoints);
}

TEST(Fuzz, hands_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("hands", fuzzHands);
}

TEST(Fuzz, pairs_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("pairs", fuzzPairs);
}

TEST(Fuzz, sensation_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("sensation", fuzzSensation);
}

TEST(Fuzz, options_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("options", fuzzOptions);
}

TEST(Fuzz, environment_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("environment", fuzzEnvironment);
}

TEST(Fuzz, scene_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("scene", fuzzScene);
}

TEST(Fuzz, osc_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("osc", fuzzOsc);
}

TEST(Fuzz, gltf_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("gltf", fuzzGltf);
}

TEST(Fuzz, monitor_keeps_its_promises_on_the_corpus_and_near_it)
{
    replay("monitor", fuzzMonitor);
}
