#pragma once

namespace midair::base
{

/// Replaces what \a to has of its base class \a Part by that of \a from.
template<class Part, class To, class From>
void assignPart(To& to, const From& from)
{
    static_cast<Part&>(to) = static_cast<const Part&>(from);
}

} // namespace midair::base
