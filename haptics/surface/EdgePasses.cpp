#include "haptics/surface/EdgePasses.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

/// Largest distance of a place on an edge from its nearest point, in spacings; less than the
/// guaranteed 1.1.
constexpr double kReach = 1.05;

struct ChainSpot
{
    const FeatureEdge* edge;
    double fraction;
};

ChainSpot spotAt(const SampleBuilder& builder, const FeatureChain& chain, double arc)
{
    auto after = std::upper_bound(chain.arc.begin(), chain.arc.end(), arc);
    after = std::clamp(after, chain.arc.begin() + 1, chain.arc.end() - 1);
    const auto step = static_cast<std::size_t>(after - chain.arc.begin() - 1);
    const double length = chain.arc[step + 1] - chain.arc[step];
    const double along =
        length > 0.0 ? std::clamp((arc - chain.arc[step]) / length, 0.0, 1.0) : 0.0;
    const auto& walked = chain.steps[step];
    return {&builder.topology().features[static_cast<std::size_t>(walked.edge)],
            walked.reversed ? 1.0 - along : along};
}

/// Returns true if neighbours along the chain, divided into \a count equal steps, are at least the
/// spacing apart in a straight line.
bool stepsKeepApart(SampleBuilder& builder, const FeatureChain& chain, int count, double shift)
{
    const double step = chain.length() / count;
    const double spacing2 = std::pow(builder.edgeSpacing() * (1.0 + 2e-9), 2);
    const auto point = [&](int i)
    {
        const double arc = std::fmod((i + shift) * step, chain.length());
        const ChainSpot spot =
            spotAt(builder, chain, i == count && !chain.closed ? chain.length() : arc);
        return builder.edgePoint(*spot.edge, spot.fraction);
    };
    // With a shift an open chain has \a count points, none at its ends; in a loop the last point's
    // neighbour is the first.
    const int last = shift > 0.0 && !chain.closed ? count - 1 : count;
    Eigen::Vector3d before = point(0);
    for (int i = 1; i <= last; ++i)
    {
        builder.look();
        const Eigen::Vector3d here = point(i);
        if ((here - before).squaredNorm() < spacing2) return false;
        before = here;
    }
    return true;
}

void placeChain(SampleBuilder& builder, const FeatureChain& chain, double shift)
{
    constexpr int kTries = 24;
    const double fitting = chain.length() / (builder.edgeSpacing() * (1.0 + 3e-9));
    if (fitting > 1e3 * builder.options().maxPoints)
    {
        throwTooManyPoints(builder.topology(), builder.options());
    }
    int count = static_cast<int>(fitting);
    for (int i = 0; i < kTries && count > 1 && !stepsKeepApart(builder, chain, count, shift); ++i)
    {
        --count; // where the curve bends, the straight distance is less than a step along it
    }
    if (count < 1) return;
    // The corners at the ends have been tried already.
    const int first = shift > 0.0 || chain.closed ? 0 : 1;
    for (int i = first; i < count; ++i)
    {
        const ChainSpot spot = spotAt(builder, chain, (i + shift) * chain.length() / count);
        builder.tryEdge(*spot.edge, spot.fraction, builder.edgeSpacing());
    }
}

} // namespace

void placeChains(SampleBuilder& builder, const std::vector<FeatureChain>& chains, double shift)
{
    for (const FeatureChain& chain : chains)
        placeChain(builder, chain, shift);
}

void fillEdges(SampleBuilder& builder)
{
    const double reach = kReach * builder.edgeSpacing();
    struct Piece
    {
        double begin, end;
    };
    std::vector<Piece> pieces;
    for (const FeatureEdge& edge : builder.topology().features)
    {
        pieces.assign(1, {0.0, 1.0});
        while (!pieces.empty())
        {
            const Piece piece = pieces.back();
            pieces.pop_back();
            const double middle = 0.5 * (piece.begin + piece.end);
            builder.tryEdge(edge, middle, builder.edgeSpacing());
            const int near = builder.points().nearest(builder.edgePoint(edge, middle), reach);
            const auto covers = [&](double fraction)
            {
                return near >= 0 &&
                       (builder.edgePoint(edge, fraction) - builder.points()[near]).squaredNorm() <=
                           reach * reach;
            };
            if (covers(piece.begin) && covers(piece.end)) continue;
            pieces.push_back({middle, piece.end});
            pieces.push_back({piece.begin, middle});
        }
    }
}

} // namespace midair::haptics
