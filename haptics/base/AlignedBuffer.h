#pragma once

#include "haptics/base/LargeMemory.h"

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>

namespace midair::base
{

/// Cache-line aligned array of plain numbers. It never shrinks, so later updates don't allocate.
template<typename T>
class AlignedBuffer
{
public:
    static constexpr std::size_t kAlignment = 64; ///< bytes; an AVX-512 register, a cache line

    /// Makes room for \a count elements. If it has to grow, all elements become zero.
    void reserve(std::size_t count)
    {
        if (count <= _capacity) return;
        reserveUnset(count);
        setZero();
    }
    /// Makes room for \a count elements that the caller writes before it reads them: if it has to
    /// grow, none of them is set.
    void reserveUnset(std::size_t count)
    {
        if (count <= _capacity) return;
        if (count > static_cast<std::size_t>(-1) / 2 / sizeof(T)) throw std::bad_alloc();
        const std::size_t bytes = count * sizeof(T);
        _data = {static_cast<T*>(takeMemory(bytes)), Give{bytes}};
        _capacity = count;
    }
    void setZero()
    {
        if (_capacity > 0) std::memset(static_cast<void*>(_data.get()), 0, _capacity * sizeof(T));
    }

    T* data() { return _data.get(); }
    const T* data() const { return _data.get(); }
    T& operator[](std::size_t i) { return _data.get()[i]; }
    const T& operator[](std::size_t i) const { return _data.get()[i]; }

private:
    struct Give
    {
        std::size_t bytes = 0;
        void operator()(T* data) const { giveMemory(data, bytes); }
    };
    std::unique_ptr<T[], Give> _data;
    std::size_t _capacity = 0;
};

} // namespace midair::base
