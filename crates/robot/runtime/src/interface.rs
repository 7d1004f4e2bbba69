//! The addresses of this machine.

use std::io;
use std::net::IpAddr;
use std::ptr::null_mut;

use crate::link::LinkError;

/// Refuses an interface that this machine does not have: the DDS library would join nothing, without an error.
///
/// # Errors
/// If no interface has this address.
pub(crate) fn check(interface: IpAddr) -> Result<(), LinkError> {
    match addresses() {
        Ok(here) if !here.contains(&interface) => Err(LinkError::Interface { found: interface, here }),
        // A system that does not list its addresses may have this one.
        Ok(_) | Err(_) => Ok(()),
    }
}

/// The IPv4 addresses of all interfaces: the DDS library uses no others.
fn addresses() -> io::Result<Vec<IpAddr>> {
    let mut first = null_mut();
    // SAFETY: the system writes where its list begins, and nothing else.
    if unsafe { libc::getifaddrs(&raw mut first) } != 0 {
        return Err(io::Error::last_os_error());
    }
    let (mut found, mut next) = (Vec::new(), first);
    // SAFETY: an entry of the system's list, or null at its end.
    while let Some(entry) = unsafe { next.as_ref() } {
        // SAFETY: null, or an address of the system that begins with its family.
        let family = unsafe { entry.ifa_addr.as_ref() }.map(|address| i32::from(address.sa_family));
        if family == Some(libc::AF_INET) {
            // SAFETY: an address of this family has this form, wherever it lies.
            let address = unsafe { entry.ifa_addr.cast::<libc::sockaddr_in>().read_unaligned() };
            // In the network's order already.
            found.push(IpAddr::from(address.sin_addr.s_addr.to_ne_bytes()));
        }
        next = entry.ifa_next;
    }
    // SAFETY: the list that the system has made, which is not read after this.
    unsafe { libc::freeifaddrs(first) };
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    #[test]
    fn the_loopback_is_one_of_this_machine_and_an_address_of_the_documentation_is_not() {
        let loopback = IpAddr::from(Ipv4Addr::LOCALHOST);
        assert_eq!(check(loopback), Ok(()));
        let error = check(IpAddr::from([192, 0, 2, 1])).expect_err("not of this machine").to_string();
        assert!(error.starts_with("interface: expected an address of this machine ("), "{error}");
        assert!(error.contains("127.0.0.1") && error.ends_with("found 192.0.2.1"), "{error}");
    }
}
