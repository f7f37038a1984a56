#pragma once

#include "plugin/hands/HandConversion.h"

#include <osgMidair/HandSource>

#include <string>
#include <utility>
#include <vector>

namespace osgMidair
{

/// Adapts a hand source of the bridge.
template<typename Source>
class BridgedHands : public HandSource
{
public:
    template<typename... Args>
    explicit BridgedHands(Args&&... args) : _source(std::forward<Args>(args)...)
    {
    }

    bool getHands(double time, std::vector<Hand>& hands) override
    {
        if (!_begun) _origin = time;
        _begun = true;
        const bool any = _source.frameAt(time - _origin, _frame);
        hands.clear();
        for (const midair::bridge::Hand& hand : _frame.hands)
            hands.push_back(fromBridge(hand));
        return any;
    }

    std::string getStatus() const override { return _source.status(); }

protected:
    Source _source;

private:
    midair::bridge::HandFrame _frame;
    bool _begun = false;
    double _origin = 0.0; ///< scene time of the first call, s
};

} // namespace osgMidair
