#include "haptics/points/PointBudget.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <tuple>

namespace midair::haptics
{

namespace
{

/// Farthest-point selection that starts with the first sample: it spreads the chosen points evenly,
/// and they stay the same while the object moves.
void spread(const std::vector<BudgetPoint>& points,
            const std::vector<std::size_t>& members,
            int quota,
            const base::StopToken& stop,
            std::vector<char>& keep)
{
    std::vector<std::size_t> order = members;
    std::sort(order.begin(),
              order.end(),
              [&](std::size_t a, std::size_t b) { return points[a].sample < points[b].sample; });
    std::vector<double> distance2(order.size(), std::numeric_limits<double>::infinity());
    std::size_t next = 0;
    for (int taken = 0; taken < quota; ++taken)
    {
        stop.throwIfRequested();
        keep[order[next]] = 1;
        const Eigen::Vector3d point = points[order[next]].position;
        distance2[next] = -1.0;
        std::size_t farthest = next;
        for (std::size_t i = 0; i < order.size(); ++i)
        {
            if (distance2[i] < 0.0) continue;
            distance2[i] =
                std::min(distance2[i], (points[order[i]].position - point).squaredNorm());
            if (distance2[i] > distance2[farthest]) farthest = i;
        }
        next = farthest;
    }
}

} // namespace

std::vector<char>
shareBudget(const std::vector<BudgetPoint>& points, int maxPoints, const base::StopToken& stop)
{
    std::vector<char> keep(points.size(), 0);
    std::map<int, std::map<int, std::vector<std::size_t>>, std::greater<>> groups;
    for (std::size_t i = 0; i < points.size(); ++i)
    {
        groups[points[i].priority][points[i].source].push_back(i);
    }
    int left = maxPoints;
    for (const auto& [priority, members] : groups)
    {
        int total = 0;
        for (const auto& member : members)
            total += static_cast<int>(member.second.size());
        const int share = std::min(left, total);
        std::vector<std::tuple<double, int, int, int>> parts; // -remainder, object, source, quota
        int given = 0;
        for (const auto& [source, own] : members)
        {
            const double exact =
                static_cast<double>(share) * static_cast<double>(own.size()) / total;
            const int quota = static_cast<int>(exact);
            const int object = points[own.front()].object;
            parts.emplace_back(quota - exact, object, source, quota);
            given += quota;
        }
        std::sort(parts.begin(), parts.end());
        for (auto& part : parts)
        {
            const auto& own = members.at(std::get<2>(part));
            int& quota = std::get<3>(part);
            if (given < share && quota < static_cast<int>(own.size()))
            {
                ++quota;
                ++given;
            }
            spread(points, own, quota, stop, keep);
        }
        left -= share;
    }
    return keep;
}

} // namespace midair::haptics
