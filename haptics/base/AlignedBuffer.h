#pragma once

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
        _data.reset(
            static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{kAlignment})));
        std::memset(static_cast<void*>(_data.get()), 0, count * sizeof(T));
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
    struct Free
    {
        void operator()(T* data) const { ::operator delete (data, std::align_val_t{kAlignment}); }
    };
    std::unique_ptr<T[], Free> _data;
    std::size_t _capacity = 0;
};

} // namespace midair::base
