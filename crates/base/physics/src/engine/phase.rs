//! Cutting the step into functions of bearable size.

/// Defines a function whose body is compiled on its own, with the lane type's instruction set enabled.
///
/// Kernels must inline everything they call, so a step as one kernel is one huge function, which takes minutes to compile
/// and runs no faster. A phase is a kernel behind a plain function that is never inlined.
macro_rules! phase {
    (
        $(#[$meta:meta])*
        $vis:vis fn $name:ident<$life:lifetime, $lane:ident $(, const $c:ident: $ct:ty)?>
        ($($arg:ident: $ty:ty),* $(,)?) -> $out:ty $body:block
    ) => {
        $(#[$meta])*
        #[inline(never)]
        $vis fn $name<$life, $lane: paid_lanes::Real $(, const $c: $ct)?>($($arg: $ty),*) -> $out {
            struct Phase<$life, $lane: paid_lanes::Real $(, const $c: $ct)?> {
                $($arg: $ty,)*
                life: core::marker::PhantomData<&$life $lane>,
            }
            impl<$life, $lane: paid_lanes::Real $(, const $c: $ct)?> paid_lanes::Kernel
                for Phase<$life, $lane $(, $c)?>
            {
                type Output = $out;
                #[inline(always)]
                fn run(self) -> $out {
                    let Self { $($arg,)* .. } = self;
                    $body
                }
            }
            $lane::run(Phase::<$life, $lane $(, $c)?> { $($arg,)* life: core::marker::PhantomData })
        }
    };
}
pub(crate) use phase;
