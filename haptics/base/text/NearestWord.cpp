#include "haptics/base/text/NearestWord.h"

#include "haptics/base/text/Quantity.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::base
{

namespace
{

/// Longer words are no names; the limit keeps a file's nonsense from costing time.
constexpr std::size_t kLongest = 64;

} // namespace

int editDistance(const std::string& a, const std::string& b)
{
    const std::string from = lowerCase(a.substr(0, kLongest));
    const std::string to = lowerCase(b.substr(0, kLongest));
    // Rows of the table of distances between beginnings: two ago, the last, this one.
    std::vector<int> before(to.size() + 1);
    std::vector<int> last(to.size() + 1);
    std::vector<int> now(to.size() + 1);
    for (std::size_t j = 0; j <= to.size(); ++j)
        last[j] = static_cast<int>(j);
    for (std::size_t i = 1; i <= from.size(); ++i)
    {
        now[0] = static_cast<int>(i);
        for (std::size_t j = 1; j <= to.size(); ++j)
        {
            const int replaced = last[j - 1] + (from[i - 1] == to[j - 1] ? 0 : 1);
            now[j] = std::min({replaced, last[j] + 1, now[j - 1] + 1});
            if (i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1])
                now[j] = std::min(now[j], before[j - 2] + 1);
        }
        std::swap(before, last);
        std::swap(last, now);
    }
    return last[to.size()];
}

std::vector<std::string> nearestWords(const std::string& word,
                                      const std::vector<std::string>& known)
{
    std::vector<std::string> nearest;
    int least = static_cast<int>(kLongest);
    for (const std::string& name : known)
    {
        const int distance = editDistance(word, name);
        if (3 * distance > static_cast<int>(std::max(word.size(), name.size())) || distance > least)
            continue;
        if (distance < least) nearest.clear();
        least = distance;
        nearest.push_back(name);
    }
    return nearest;
}

std::string didYouMean(const std::string& word, const std::vector<std::string>& known)
{
    const std::vector<std::string> nearest = nearestWords(word, known);
    return nearest.empty() ? "" : fmt::format(" (did you mean {}?)", fmt::join(nearest, " or "));
}

} // namespace midair::base
