use pt_core::{Buffer, Device, Location, Result};

/// A table on the device whose content is replaced now and then. With two copies, the content of the last frame stays: a replacement goes
/// to the other copy.
pub(crate) struct Table {
    copies: Vec<Buffer>,
    now: usize,
}

impl Table {
    /// A table of that many bytes; two of them with `keeps_last`.
    pub(crate) fn new(device: &Device, name: &str, bytes: usize, keeps_last: bool) -> Result<Self> {
        let mut table = Self { copies: Vec::new(), now: 0 };
        for _ in 0..1 + usize::from(keeps_last) {
            table.copies.push(Buffer::new(device, name, bytes as u64, Location::Device)?);
        }
        Ok(table)
    }

    /// From now on with or without a second copy.
    pub(crate) fn keep_last(&mut self, device: &Device, keeps_last: bool) -> Result<()> {
        if keeps_last && self.copies.len() == 1 {
            let copy = Buffer::new(device, self.now().name(), self.now().size(), Location::Device)?;
            self.copies.push(copy);
        } else if !keeps_last {
            self.copies = vec![self.now().clone()];
            self.now = 0;
        }
        Ok(())
    }

    /// Where new content goes, at most once a frame; it is what the table has from now on.
    pub(crate) fn replace(&mut self) -> &Buffer {
        self.now = (self.now + 1) % self.copies.len();
        self.now()
    }

    pub(crate) fn now(&self) -> &Buffer {
        &self.copies[self.now]
    }

    pub(crate) fn address(&self) -> u64 {
        self.now().address()
    }

    pub(crate) fn copies(&self) -> &[Buffer] {
        &self.copies
    }
}
