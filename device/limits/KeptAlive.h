#pragma once

namespace midair::device
{

/// What falls silent by itself (SafetyLimits::hold_s) unless fields come, or word that the one that
/// plays is still wanted. So an application that stands still is silenced, and an object that
/// rests is not. A device that is a KeptAlive says so by its class; others hold their field for
/// good.
class KeptAlive
{
public:
    virtual ~KeptAlive() = default;

    /// Says that what is played is still wanted; what is silent stays so. Never waits. Any thread.
    virtual void keepAlive() = 0;

    /// Longest time without a field and without keepAlive(), s; 0: for good. Any thread.
    virtual double hold_s() const = 0;
};

} // namespace midair::device
