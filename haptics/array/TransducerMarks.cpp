// What files and users say of single transducers: which are dead, and the gains of weak ones.
#include "haptics/array/TransducerMarks.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/IndexList.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using Json = base::JsonReader::Json;
using Reader = base::JsonReader;

void readDead(const Reader& reader, const Json& list, TransducerArray& array)
{
    const std::string right = fmt::format("the number of a transducer, 0 to {}", array.size() - 1);
    reader.list(list, "dead", "a list of numbers of transducers, from 0");
    std::vector<int> dead;
    std::vector<bool> seen(static_cast<std::size_t>(array.size()));
    for (const Json& item : list)
    {
        const std::string path = Reader::at("dead", dead.size());
        const int i = reader.integer(item, path, 0, array.size() - 1, right);
        if (seen[static_cast<std::size_t>(i)]) reader.wrong(path, item, "there once");
        seen[static_cast<std::size_t>(i)] = true;
        dead.push_back(i);
    }
    array.setDead(dead);
}

void readWeak(const Reader& reader, const Json& list, TransducerArray& array)
{
    const std::string right = fmt::format(
        "[number of a transducer, 0 to {}, gain above 0 and at most 1000]", array.size() - 1);
    reader.list(list, "weak", "a list of [number of a transducer, gain]");
    std::vector<std::pair<int, double>> weak;
    std::vector<bool> seen(static_cast<std::size_t>(array.size()));
    for (const Json& item : list)
    {
        const std::string path = Reader::at("weak", weak.size());
        if (!item.is_array() || item.size() != 2) reader.wrong(path, item, right);
        const int i =
            reader.integer(item[0], Reader::at(path, std::size_t{0}), 0, array.size() - 1, right);
        const double value =
            reader.number(item[1], Reader::at(path, std::size_t{1}), 0.0, kMostGain, right);
        if (!(value > 0.0)) reader.wrong(path, item, right + "; what does nothing is dead");
        if (seen[static_cast<std::size_t>(i)]) reader.wrong(path, item, "there once");
        if (std::binary_search(array.dead.begin(), array.dead.end(), i))
            reader.wrong(path, item, "of a transducer that isn't dead");
        seen[static_cast<std::size_t>(i)] = true;
        weak.emplace_back(i, value);
    }
    array.setGains(weak);
}

} // namespace

void readMarks(const Reader& reader, const Json& root, TransducerArray& array)
{
    if (root.contains("dead")) readDead(reader, root["dead"], array);
    if (root.contains("weak")) readWeak(reader, root["weak"], array);
}

void TransducerArray::setGains(const std::vector<std::pair<int, double>>& which)
{
    if (which.empty()) return;
    if (gain.size() == 0) gain.setOnes(size());
    for (const auto& [i, value] : which)
        gain[i] = value;
}

void TransducerArray::mark(const std::string& deadText, const std::string& weakText)
{
    const std::vector<int> more = base::parseIndices(deadText, "dead");
    const auto gains = base::parseIndexedNumbers(weakText, "weak", kMostGain);
    const auto refuseBeyond = [this](const char* what, int i)
    {
        if (i >= size())
            throw base::InputError(fmt::format(
                "{} has {}; the array has {} transducers, 0 to {}", what, i, size(), size() - 1));
    };
    if (!more.empty()) refuseBeyond("dead", more.back());
    if (!gains.empty()) refuseBeyond("weak", gains.back().first);
    setDead(more);
    for (const auto& [i, value] : gains)
        if (std::binary_search(dead.begin(), dead.end(), i))
            throw base::InputError(
                fmt::format("weak has {}, which is dead; it can be only one of both", i));
    setGains(gains);
}

} // namespace midair::haptics
